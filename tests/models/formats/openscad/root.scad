translate([100, 0, 0]) {
    !rotate(90) cube([30, 10, 10]);
    sphere(50);
}
cube(99);
