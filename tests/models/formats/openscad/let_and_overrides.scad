width = 3;
let (width = 12, depth = width / 2) cube([width, depth, size]);
size = 9;
size = 4;
