"""The CSG modeler and the CAD library."""
