linear_extrude(4)
    offset(r = 2)
        difference() { square(20); square(10); }
