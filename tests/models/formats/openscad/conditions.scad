big = true;
small = undef;
if (big && !(1 > 2) || false) cube(20); else sphere(99);
if (small == undef) translate([30, 0, 0]) cube(10); else if (big) sphere(98);
if (is_undef(never_defined) && is_num(3) && is_list([]) && is_string("") && is_bool(big))
    translate([60, 0, 0]) cube(5);
