rotate_extrude() difference() {
    translate([5, -10]) square([25, 20]);
    translate([30, 0]) circle(4);
}
