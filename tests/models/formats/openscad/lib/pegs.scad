use <deep/caps.scad>
height = 25;
module peg(r) { cylinder(r = r, h = height); translate([0, 0, height]) cap(r); }
cube(1000);
