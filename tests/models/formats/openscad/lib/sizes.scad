peg_radius = 7;
