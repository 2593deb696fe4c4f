double = function (x) 2 * x;
twice = function (f, x) f(f(x));
cube(twice(double, 3));
