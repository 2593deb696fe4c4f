rotate_extrude()
    square(10, center = true);
