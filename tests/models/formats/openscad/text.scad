difference() {
    cube([60, 20, 5]);
    translate([5, 5, 3])
        linear_extrude(5) text("PALPATE");
}
