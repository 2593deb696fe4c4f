intersection() { cube(30, center = true); sphere(19); }
translate([60, 0, 0]) intersection_for (a = [0, 60, 120]) rotate(a) cube([60, 20, 10], center = true);
