rotate_extrude(angle = 90) translate([20, 0]) circle(5);
translate([0, 0, 30]) rotate_extrude(angle = -60) translate([10, 0]) square([10, 6]);
