"""A plan of a solid as JSON on stdin, STEP on stdout: the only user of OCP, run as a program of its own.

The kernel prints what it does, takes a second to load and may crash on a boolean; so it runs by file name in
isolated mode and imports nothing of ours.  A plan is a list: `["cube", x, y, z]`, `["cylinder", radius, height]`,
`["cone", bottom, top, height]`, `["sphere", radius]`, `["torus", major, minor]`, `["polyhedron", points, faces]`,
`["placed", rows of a (3, 4) pose, plan]`, or `["union" | "intersection" | "difference", plan, plan, ...]`;
primitives are centered, their axis along z, in mm.
"""

import json
import os
import sys
import tempfile
from collections.abc import Callable
from functools import reduce
from typing import Any


def main() -> int:
    """0 with the STEP written, 3 where the kernel made nothing of the plan."""
    answer = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    plan, name = json.load(sys.stdin)
    data = _step(_simplified(_shape(plan)), name)
    with os.fdopen(answer, "wb") as out:
        out.write(data)
    return 0 if data else 3


def _shape(plan: list[Any]) -> Any:
    kind, *told = plan
    return _MAKERS[kind](*told)


def _cube(x: float, y: float, z: float) -> Any:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
    from OCP.gp import gp_Pnt

    return BRepPrimAPI_MakeBox(gp_Pnt(-x / 2, -y / 2, -z / 2), x, y, z).Shape()


def _cylinder(radius: float, height: float) -> Any:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder

    return BRepPrimAPI_MakeCylinder(_axes(-height / 2), radius, height).Shape()


def _cone(bottom: float, top: float, height: float) -> Any:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCone

    return BRepPrimAPI_MakeCone(_axes(-height / 2), bottom, top, height).Shape()


def _sphere(radius: float) -> Any:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeSphere

    return BRepPrimAPI_MakeSphere(radius).Shape()


def _torus(major: float, minor: float) -> Any:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeTorus

    return BRepPrimAPI_MakeTorus(major, minor).Shape()


def _polyhedron(points: list[list[float]], faces: list[list[int]]) -> Any:
    from OCP.BRepBuilderAPI import (
        BRepBuilderAPI_MakeFace,
        BRepBuilderAPI_MakePolygon,
        BRepBuilderAPI_MakeSolid,
        BRepBuilderAPI_Sewing,
    )
    from OCP.BRepLib import BRepLib
    from OCP.gp import gp_Pnt
    from OCP.TopoDS import TopoDS

    sewing = BRepBuilderAPI_Sewing(1e-6)
    for face in faces:
        outline = BRepBuilderAPI_MakePolygon()
        for corner in face:
            outline.Add(gp_Pnt(*points[corner]))
        outline.Close()
        sewing.Add(BRepBuilderAPI_MakeFace(outline.Wire(), True).Face())
    sewing.Perform()
    cast = getattr(TopoDS, "Shell_s", None) or TopoDS.Shell  # OCP 8 dropped the ending
    solid = BRepBuilderAPI_MakeSolid(cast(sewing.SewedShape())).Solid()
    BRepLib.OrientClosedSolid_s(solid)
    return solid


def _placed(rows: list[list[float]], plan: list[Any]) -> Any:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
    from OCP.gp import gp_Trsf

    motion = gp_Trsf()
    motion.SetValues(*(value for row in rows for value in row))
    return BRepBuilderAPI_Transform(_shape(plan), motion, True).Shape()


def _union(*plans: list[Any]) -> Any:
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse

    return reduce(lambda a, b: BRepAlgoAPI_Fuse(a, b).Shape(), map(_shape, plans))


def _intersection(*plans: list[Any]) -> Any:
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Common

    return reduce(lambda a, b: BRepAlgoAPI_Common(a, b).Shape(), map(_shape, plans))


def _difference(*plans: list[Any]) -> Any:
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut

    return reduce(lambda a, b: BRepAlgoAPI_Cut(a, b).Shape(), map(_shape, plans))


def _axes(z: float) -> Any:
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    return gp_Ax2(gp_Pnt(0, 0, z), gp_Dir(0, 0, 1))


def _simplified(shape: Any) -> Any:
    """Neighboring faces on one surface made one, as a person would draw them."""
    from OCP.ShapeUpgrade import ShapeUpgrade_UnifySameDomain

    unify = ShapeUpgrade_UnifySameDomain(shape, True, True, False)
    unify.Build()
    return unify.Shape()


def _step(shape: Any, name: str) -> bytes:
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.Interface import Interface_Static
    from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

    writer = STEPControl_Writer()
    Interface_Static.SetCVal_s("write.step.unit", "MM")
    Interface_Static.SetCVal_s("write.step.product.name", name)
    done = IFSelect_ReturnStatus.IFSelect_RetDone
    if writer.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs) != done:
        return b""
    with tempfile.TemporaryDirectory(prefix="palpate-") as scratch:
        path = os.path.join(scratch, "model.step")
        if writer.Write(path) != done:
            return b""
        with open(path, "rb") as written:
            return written.read()


_MAKERS: dict[str, Callable[..., Any]] = {
    "cube": _cube,
    "cylinder": _cylinder,
    "cone": _cone,
    "sphere": _sphere,
    "torus": _torus,
    "polyhedron": _polyhedron,
    "placed": _placed,
    "union": _union,
    "intersection": _intersection,
    "difference": _difference,
}

if __name__ == "__main__":
    sys.exit(main())
