hull() for (x = [-20, 20], y = [-10, 10]) translate([x, y, 0]) cylinder(r = 5, h = 8);
translate([0, 0, 30]) hull() { cube([20, 20, 1], center = true); translate([0, 0, 10]) cube([10, 10, 1], center = true); }
translate([0, 0, 60]) minkowski() { cube([20, 10, 4]); cylinder(r = 3, h = 2); }
