include <lib/sizes.scad>
use <lib/pegs.scad>
peg(peg_radius);
