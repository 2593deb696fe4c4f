function checked(x) = assert(x > 0, "x must be positive") x;
assert(true);
cube(checked(5));
translate([20, 0, 0])
    cube(checked(-5));
