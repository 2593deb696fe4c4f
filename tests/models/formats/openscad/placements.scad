rotate([90, 0, 45]) translate([0, 0, 10]) cylinder(h = 20, r1 = 8, r2 = 4);
rotate(a = 120, v = [1, 1, 1]) translate([40, 0, 0]) cube([10, 20, 30], center = true);
mirror([1, 0, 0]) translate([30, 0, 0]) linear_extrude(5) polygon([[0, 0], [10, 0], [0, 20]]);
multmatrix([[1, 0, 0, 0], [0, 1, 0, 50], [0, 0, 1, 0]]) sphere(5);
