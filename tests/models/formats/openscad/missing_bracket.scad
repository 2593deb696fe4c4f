difference() {
    cube(20);
    sphere(12;
}
