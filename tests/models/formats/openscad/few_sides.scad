cylinder(r = 10, h = 5, $fn = 6);
