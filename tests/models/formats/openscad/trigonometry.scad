echo(sin(30), cos(60), tan(45));
cube([20 * sin(30), 10 * (cos(60) + sin(210)) + 5, 8 * tan(45) + atan2(1, 1) / 45 + acos(0) / 90 + asin(1) / 90 + atan(1) / 45]);
