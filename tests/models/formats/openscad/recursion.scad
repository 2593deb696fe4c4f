function total(v, i = 0) = i == len(v) ? 0 : v[i] + total(v, i + 1);
function count(n, sum = 0) = n == 0 ? sum : count(n - 1, sum + 1);
module tower(n, z = 0) {
    if (n > 0) {
        translate([0, 0, z]) cube([10 * n, 10 * n, 10], center = true);
        tower(n - 1, z + 10);
    }
}
tower(total([1, 1, 1]));
translate([0, 0, -10]) cube([count(5000) / 100, 8, 10], center = true);
