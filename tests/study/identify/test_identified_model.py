"""What is seen of a model that an identification writes."""

from __future__ import annotations

from xml.etree import ElementTree

from nipper_pin.study.identify.write import _show_collision_shapes

LINK = """<link name="{name}">
  <visual name="mesh"><geometry><mesh filename="a.stl"/></geometry></visual>
  <visual name="pin"><geometry><sphere radius="1"/></geometry></visual>
  <collision name="bar"><geometry><box size="1 2 3"/></geometry></collision>
</link>"""


def test_links_with_meshes_show_their_plain_bodies() -> None:
    """A mesh was drawn for the old places of the pins; links without one look as they did."""
    plain = LINK.format(name="plain").replace('<mesh filename="a.stl"/>', '<sphere radius="2"/>')
    text = f'<robot name="two">{LINK.format(name="drawn")}{plain}</robot>'
    root = ElementTree.fromstring(text)
    _show_collision_shapes(root)
    drawn, other = root.findall("link")
    assert [item.tag for item in drawn] == ["collision", "visual"]
    box = drawn.find("visual/geometry/box")
    assert box is not None
    assert box.get("size") == "1 2 3"
    assert ElementTree.tostring(other) == ElementTree.tostring(ElementTree.fromstring(plain))
