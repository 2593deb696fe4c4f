scale([2, 2, 3]) cylinder(r = 5, h = 4);
translate([50, 0, 0]) scale([1, 2, 3]) cube(10);
translate([0, 50, 0]) scale(3) sphere(4);
translate([50, 50, 0]) resize([10, 10, 30]) cylinder(r = 1, h = 1);
