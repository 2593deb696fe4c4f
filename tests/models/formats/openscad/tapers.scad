linear_extrude(height = 20, scale = 0.5) square(20, center = true);
translate([40, 0, 0]) linear_extrude(height = 15, scale = 0) polygon([[-10, -10], [10, -10], [0, 10]]);
translate([80, 0, 0]) linear_extrude(height = 10, scale = 2) circle(6);
