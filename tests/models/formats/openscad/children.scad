module row(n, step) {
    for (i = [0 : n - 1]) translate([i * step, 0, 0]) children(0);
    translate([0, 20, 0]) children(1);
    translate([0, 40, 0]) cube($children);
}
row(3, 12) {
    cube(10, center = true);
    sphere(d = 8);
}
