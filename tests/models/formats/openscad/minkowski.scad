minkowski() {
    difference() { cube(20); cube(10); }
    sphere(3);
}
