s = str("a", 1.5, true, [1, "b"]);       // a1.5true[1, "b"]
t = "plate\n";
cube([len(s), len(t), ord("A") - len(chr(66)) - (s[1] == "1" ? 54 : 0)]);
