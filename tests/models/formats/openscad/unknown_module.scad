include <lib/sizes.scad>

gear(teeth = 20);
