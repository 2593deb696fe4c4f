module cap(r) { difference() { sphere(r); translate([-50, -50, -100]) cube(100); } }
