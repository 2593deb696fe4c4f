translate([1, 2, 3])
    circle(4);
