cube([10, 20, 30])
sphere(5);
