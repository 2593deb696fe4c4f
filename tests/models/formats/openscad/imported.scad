// a mesh is no tree
union() {
    cube(10);
    import("part.stl");
}
