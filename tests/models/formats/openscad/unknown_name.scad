width = 10;
cube([width,
      depth,
      3]);
