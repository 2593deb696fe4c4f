linear_extrude(10) {
    circle(3);
    sphere(3);
}
