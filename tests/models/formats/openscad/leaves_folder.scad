cube(10);
include <../../../../conftest.py>
