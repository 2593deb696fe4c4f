"""STEP files written by hand: AP214 text of prisms over polygons and of round bars cut along two seams."""

import itertools
import math

import pytest

HEAD = (
    "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n"
    "FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;\n"
)
UNITS = {
    "mm": "(LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.))",
    "m": "(LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT($,.METRE.))",
}


class StepText:
    """Entities in the order of their numbers."""

    def __init__(self, unit="mm"):
        self.lines = []
        self.solids = []
        self.unit = unit
        self.vertices = {}
        self.edges = {}

    def add(self, text):
        self.lines.append(f"#{len(self.lines) + 1}={text};")
        return f"#{len(self.lines)}"

    def point(self, p):
        return self.add(f"CARTESIAN_POINT('',({p[0]:.12G},{p[1]:.12G},{p[2]:.12G}))".replace("E+", "E"))

    def direction(self, d):
        return self.add(f"DIRECTION('',({float(d[0])},{float(d[1])},{float(d[2])}))")

    def axes(self, origin, axis, x):
        parts = self.point(origin), self.direction(axis), self.direction(x)
        return self.add(f"AXIS2_PLACEMENT_3D('',{','.join(parts)})")

    def vertex(self, p):
        if p not in self.vertices:
            self.vertices[p] = self.add(f"VERTEX_POINT('',{self.point(p)})")
        return self.vertices[p]

    def line(self, a, b):
        if (b, a) in self.edges:
            return self.add(f"ORIENTED_EDGE('',*,*,{self.edges[b, a]},.F.)")
        if (a, b) not in self.edges:
            way = [q - p for p, q in zip(a, b, strict=True)]
            long = math.dist(a, b)
            vector = self.add(f"VECTOR('',{self.direction([w / long for w in way])},{long})")
            curve = self.add(f"LINE('',{self.point(a)},{vector})")
            self.edges[a, b] = self.add(f"EDGE_CURVE('',{self.vertex(a)},{self.vertex(b)},{curve},.T.)")
        return self.add(f"ORIENTED_EDGE('',*,*,{self.edges[a, b]},.T.)")

    def arc(self, a, b, center, radius, forth):
        """Counterclockwise seen from above, from a to b, or the other way round."""
        key = (a, b, center)
        if key not in self.edges:
            circle = self.add(f"CIRCLE('',{self.axes(center, (0, 0, 1), (1, 0, 0))},{float(radius)})")
            self.edges[key] = self.add(f"EDGE_CURVE('',{self.vertex(a)},{self.vertex(b)},{circle},.T.)")
        return self.add(f"ORIENTED_EDGE('',*,*,{self.edges[key]},.{'T' if forth else 'F'}.)")

    def face(self, edges, surface, along=True):
        loop = self.add(f"EDGE_LOOP('',({','.join(edges)}))")
        bound = self.add(f"FACE_OUTER_BOUND('',{loop},.T.)")
        return self.add(f"ADVANCED_FACE('',({bound}),{surface},.{'T' if along else 'F'}.)")

    def plane(self, origin, normal, x):
        return self.add(f"PLANE('',{self.axes(origin, normal, x)})")

    def shell(self, faces, closed=True):
        if not closed:
            shell = self.add(f"OPEN_SHELL('',({','.join(faces)}))")
            self.solids.append(self.add(f"SHELL_BASED_SURFACE_MODEL('',({shell}))"))
            return
        shell = self.add(f"CLOSED_SHELL('',({','.join(faces)}))")
        self.solids.append(self.add(f"MANIFOLD_SOLID_BREP('',{shell})"))

    def text(self):
        unit = self.add(UNITS[self.unit] if self.unit in UNITS else self._inch())
        angle = self.add("(NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.))")
        solid = self.add("(NAMED_UNIT(*) SI_UNIT($,.STERADIAN.) SOLID_ANGLE_UNIT())")
        exact = self.add(f"UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-7),{unit},'d','')")
        context = self.add(
            "(GEOMETRIC_REPRESENTATION_CONTEXT(3) "
            f"GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({exact})) "
            f"GLOBAL_UNIT_ASSIGNED_CONTEXT(({unit},{angle},{solid})) REPRESENTATION_CONTEXT('',''))"
        )
        place = self.axes((0, 0, 0), (0, 0, 1), (1, 0, 0))
        held = ",".join([place, *self.solids])
        shape = self.add(f"ADVANCED_BREP_SHAPE_REPRESENTATION('',({held}),{context})")
        app = self.add("APPLICATION_CONTEXT('automotive design')")
        frame = self.add(f"PRODUCT_CONTEXT('',{app},'mechanical')")
        product = self.add(f"PRODUCT('part','part','',({frame}))")
        version = self.add(f"PRODUCT_DEFINITION_FORMATION('','',{product})")
        stage = self.add(f"PRODUCT_DEFINITION_CONTEXT('part definition',{app},'design')")
        definition = self.add(f"PRODUCT_DEFINITION('design','',{version},{stage})")
        meaning = self.add(f"PRODUCT_DEFINITION_SHAPE('','',{definition})")
        self.add(f"SHAPE_DEFINITION_REPRESENTATION({meaning},{shape})")
        return HEAD + "\n".join(self.lines) + "\nENDSEC;\nEND-ISO-10303-21;\n"

    def _inch(self):
        meter = self.add("(LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT($,.METRE.))")
        measure = self.add(f"LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(0.0254),{meter})")
        size = self.add("DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.)")
        return f"(CONVERSION_BASED_UNIT('INCH',{measure}) LENGTH_UNIT() NAMED_UNIT({size}))"


def box_faces(step, size, at=(0.0, 0.0, 0.0)):
    """Six planes."""
    corner = {
        bits: tuple(o + b * s for o, b, s in zip(at, bits, size, strict=True))
        for bits in itertools.product((0, 1), repeat=3)
    }
    faces = []
    for axis, side in itertools.product(range(3), (0, 1)):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        round_ = [(0, 0), (1, 0), (1, 1), (0, 1)] if side else [(0, 0), (0, 1), (1, 1), (1, 0)]
        run = []
        for a, b in round_:
            bits = [0, 0, 0]
            bits[axis], bits[u], bits[v] = side, a, b
            run.append(corner[tuple(bits)])
        edges = [step.line(p, q) for p, q in zip(run, [*run[1:], run[0]], strict=True)]
        normal, x = [0.0] * 3, [0.0] * 3
        normal[axis], x[u] = 1.0 if side else -1.0, 1.0
        faces.append(step.face(edges, step.plane(run[0], normal, x)))
    return faces


def bar_faces(step, radius, height):
    """A round bar whose side is in two halves."""
    low, high = (0.0, 0.0, 0.0), (0.0, 0.0, float(height))
    a, b = (float(radius), 0.0, 0.0), (-float(radius), 0.0, 0.0)
    c, d = (a[0], 0.0, high[2]), (b[0], 0.0, high[2])
    side = step.add(f"CYLINDRICAL_SURFACE('',{step.axes(low, (0, 0, 1), (1, 0, 0))},{float(radius)})")

    def arc(p, q, center, forth=True):
        return step.arc(p, q, center, radius, forth)

    return [
        step.face([arc(a, b, low), step.line(b, d), arc(c, d, high, False), step.line(c, a)], side),
        step.face([arc(b, a, low), step.line(a, c), arc(d, c, high, False), step.line(d, b)], side),
        step.face([arc(b, a, low, False), arc(a, b, low, False)], step.plane(low, (0, 0, -1), (1, 0, 0))),
        step.face([arc(c, d, high), arc(d, c, high)], step.plane(high, (0, 0, 1), (1, 0, 0))),
    ]


@pytest.fixture
def step_box():
    """Text of a box in any unit, whole or without its last faces, or of several boxes."""

    def made(size=(20.0, 30.0, 40.0), unit="mm", without=0, at=((0.0, 0.0, 0.0),), sewn=True):
        step = StepText(unit)
        for place in at:
            faces = box_faces(step, size, place)
            step.shell(faces[: len(faces) - without], closed=sewn)
        return step.text()

    return made


@pytest.fixture
def step_bar():
    """Text of a round bar along z."""

    def made(radius=10.0, height=30.0, unit="mm"):
        step = StepText(unit)
        step.shell(bar_faces(step, radius, height))
        return step.text()

    return made
