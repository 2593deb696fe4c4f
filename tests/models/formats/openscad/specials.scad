module outer() { $size = 12; inner(); }
module inner() { sphere(r = $size); }
outer();
$fa = 1;
$fs = 0.4;
