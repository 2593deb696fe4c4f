squares = [for (i = [1 : 4]) i * i];                  // 1 4 9 16
odd = [for (x = squares) if (x % 2 == 1) x];           // 1 9
both = [each odd, for (a = [1, 2], b = [10, 20]) a + b]; // 1 9 11 21 12 22
steps = [for (i = 0, s = 0; i < 4; i = i + 1, s = s + i) s]; // 0 1 3 6
pick = [for (i = [0 : 3]) let (j = 2 * i) if (j > 2) j else -1]; // -1 -1 4 6
cube([both[2], len(both) + squares[3], steps[3] + pick[3]]);
