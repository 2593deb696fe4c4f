difference() {
    cube(20, center = true);
    %cylinder(r = 5, h = 50, center = true);
    *sphere(30);
    #translate([0, 0, 10]) cube(10, center = true);
}
