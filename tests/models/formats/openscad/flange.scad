// A flange with bolt holes on a circle.
bolts = 6;
radius = 30;
thick = 10;

module hole(d, depth = 50) {
    translate([0, 0, -depth / 2]) cylinder(d = d, h = depth);
}

difference() {
    cylinder(r = radius + 10, h = thick);
    for (i = [0 : bolts - 1])
        rotate([0, 0, i * 360 / bolts]) translate([radius, 0, 0]) hole(8);
    hole(d = 22);
}
