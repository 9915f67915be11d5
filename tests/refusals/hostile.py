"""Mistakes that are too long for a reviewed text, or no text; edits, and files beside a model."""

from __future__ import annotations

from tests.refusals.bases import Edits

LIP = '<box size="0.012 0.2 0.0003"/>'
MASS = '<mass value="1.2"/>'
Mistake = tuple[Edits, dict[str, bytes]]


def chain(count: int = 10_000) -> str:
    """Links that hang from one another by fixed joints."""
    return "".join(
        f'<link name="c{k}"/><joint name="j{k}" type="fixed">'
        f'<parent link="{f"c{k - 1}" if k else "rocker"}"/><child link="c{k}"/></joint>'
        for k in range(count)
    )


def whole(text: str) -> Mistake:
    """The URDF as a whole, in letters of one byte each."""
    return (), {"small.urdf": text.encode("latin-1")}


def shape(content: bytes) -> Mistake:
    return (LIP, '<mesh filename="bad.stl"/>'), {"bad.stl": content}


EXPLODE = '<!ENTITY a0 "aaaaaaaaaa">' + "".join(
    f'<!ENTITY a{n} "{f"&a{n - 1};" * 10}">' for n in range(1, 12)
)
HEAD = '<?xml version="1.0"?>'
# By table and name.
HOSTILE: dict[str, dict[str, Mistake]] = {
    "starts_and_stops": {
        "deep TOML": (("x = " + "[" * 10**5 + "]" * 10**5,), {}),
        "long number": (("degrees_of_freedom = 3", f"degrees_of_freedom = {'9' * 5000}"), {}),
    },
    "small_urdfs": {
        "package that cannot be read": (
            ("</inertial></link>", "</inertial><collision name='x'><geometry><mesh "
             "filename='package://mine/x.stl'/></geometry></collision></link>"),
            {"package.xml": b"<p>", "x.stl": b""}),
        "nothing that moves": whole('<robot name="u"><link name="base"/></robot>'),
        **{f"letters of another encoding than {name}": whole(
            f'<?xml version="1.0" encoding="{name}"?><robot name="gr\u00f6\u00dfer"/>')
           for name in ("utf-8", "us-ascii", "klingon", "hex", "utf-16")},
    },
    # What once ended in a traceback, a crash or a wait without end.
    "hostile": {
        "deep XML": (("</robot>", "<a>" * 10**5 + "</a>" * 10**5 + "</robot>"), {}),
        "chain of links": (("</robot>", chain() + "</robot>"), {}),
        "entities that explode": (
            (HEAD, f"{HEAD}<!DOCTYPE robot [{EXPLODE}]>", MASS, '<mass value="&a11;"/>'), {}),
        "mesh cut off": shape(b"solid x\nfacet normal nan"),
        "mesh of no length": shape(b"\0" * 80 + b"\xff\xff\xff\x7f" + b"\0" * 10),
        "mesh of no numbers": shape(b"solid x\nfacet normal 0 0 1\nouter loop\nvertex nan 0 0\n"
                                    b"vertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"),
    },
    "files": {
        "bytes": ((), {"coil.csv": b"coordinate_mm,force_N\n\xff\xfe,1\n"}),
        "no text": ((), {"small.toml": b"\xff\xfe"}),
        "long field": ((), {"coil.csv": b"coordinate_mm,force_N\n" + b"1" * 200_000 + b",1\n"}),
    },
}  # fmt: skip
