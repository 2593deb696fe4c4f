// a bar with both rims broken
rotate([30, 20, 0]) hull() {
    translate([0, 0, 1]) cylinder(r = 10, h = 8);
    cylinder(r = 9, h = 10);
}
