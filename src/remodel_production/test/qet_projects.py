"""Small projects of QElectroTech: breakers, lamps, folio references and contacts."""

COLLECTION = """
<collection><category name="import">
  <category name="20_manufacturers_articles"><element name="breaker.elmt">
    <definition link_type="master" type="element"><description>
      <terminal uuid="{t1}" x="-10" y="-20" orientation="n"/>
      <terminal uuid="{t2}" x="10" y="-20" orientation="n"/>
      <terminal uuid="{b1}" x="-10" y="20" orientation="s"/>
      <terminal uuid="{b2}" x="10" y="20" orientation="s"/>
    </description></definition></element></category>
  <category name="500_home_installation"><element name="lamp.elmt">
    <definition link_type="simple" type="element"><description>
      <terminal uuid="{l}" x="0" y="0" orientation="n"/>
    </description></definition></element></category>
  <category name="100_folio_referencing"><element name="arrow.elmt">
    <definition link_type="next_report" type="element"><description>
      <terminal uuid="{r}" x="0" y="0" orientation="w"/>
    </description></definition></element></category>
  <category name="relays"><element name="contact.elmt">
    <definition link_type="slave" type="element"><description>
      <terminal uuid="{c1}" x="0" y="-10" orientation="n"/>
      <terminal uuid="{c2}" x="0" y="10" orientation="s"/>
    </description></definition></element></category>
</category></collection>
"""
BREAKER = "embed://import/20_manufacturers_articles/breaker.elmt"
LAMP = "embed://import/500_home_installation/lamp.elmt"
ARROW = "embed://import/100_folio_referencing/arrow.elmt"
CONTACT = "embed://import/relays/contact.elmt"
TERMINALS = {
    BREAKER: ((-10, -20, 0), (10, -20, 0), (-10, 20, 2), (10, 20, 2)),
    LAMP: ((0, 0, 0),),
    ARROW: ((0, 0, 3),),
    CONTACT: ((0, -10, 0), (0, 10, 2)),
}


def element(kind, uuid, label="", link="", first_id=0):
    terminals = "".join(
        f'<terminal id="{first_id + n}" x="{x}" y="{y}" orientation="{o}"/>'
        for n, (x, y, o) in enumerate(TERMINALS[kind])
    )
    return (
        f'<element type="{kind}" uuid="{uuid}"><terminals>{terminals}</terminals>'
        f'<elementInformations><elementInformation name="label">{label}</elementInformation>'
        f"</elementInformations>"
        f"<links_uuids>{f'<link_uuid uuid={link!r}/>' if link else ''}</links_uuids></element>"
    )


def wire(element1, terminal1, element2, terminal2, more=""):
    return (
        f'<conductor element1="{element1}" terminal1="{{{terminal1}}}" element2="{element2}" '
        f'terminal2="{{{terminal2}}}" {more}/>'
    )


def project(*folios):
    diagrams = "".join(
        f"<diagram><elements>{''.join(elements)}</elements>\n"
        f"<conductors>{chr(10).join(conductors)}</conductors></diagram>"
        for elements, conductors in folios
    )
    return f'<project title="Test" version="0.90">{diagrams}{COLLECTION}</project>'.encode()
