linear_extrude(height = 6) difference() {
    square([80, 40], center = true);
    for (x = [-25, 25]) translate([x, 0]) circle(d = 12);
    hull() { translate([0, -8]) circle(3); translate([0, 8]) circle(3); }
}
