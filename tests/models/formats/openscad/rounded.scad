minkowski() { cube([10, 20, 5]); sphere(3); }
translate([50, 0, 0]) hull() { sphere(5); translate([12, 0, 16]) sphere(5); }
translate([0, 0, 40]) linear_extrude(4) offset(r = 2) square([10, 20]);
translate([0, 0, 60]) linear_extrude(4) offset(delta = -1) square([10, 20]);
