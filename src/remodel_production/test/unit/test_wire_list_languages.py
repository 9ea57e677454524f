"""Wire lists of strangers in five languages: what they mean, and which columns are not used."""

import pytest
from wire_lists import read, rows

# Name: list, its wires, and its columns that are not used.
LISTS = {
    "a German harness, abbreviated": (
        "Ltg-Nr;Stecker 1;Kammer 1;Stecker 2;Kammer 2;Qs;Fb;Lg mm;Dichtung 1;Dichtung 2;"
        "Bemerkung\n"
        "L100;A12;3;B7;1;0,35;ws/gn;1830;D1;;neu\n",
        [("L100", "A12:3", "B7:1", "WHGN", 0.35, 1.83)],
        ["Bemerkung"],
    ),
    "a German pin list of cores": (
        "Steckverbinder;Pin;Ader;Farbe;Querschnitt\n"
        "X1;1;A1;rt;0,5\n"
        "X1;2;A2;bl;0,5\n"
        "X2;5;A1;rt;0,5\n"
        "X2;6;A2;bl;0,5\n",
        [("A1", "X1:1", "X2:5", "RD", 0.5, None), ("A2", "X1:2", "X2:6", "BU", 0.5, None)],
        [],
    ),
    "a German cabinet with numbers of cores, and potentials": (
        "Ader-Nr;Quelle BMK;Quelle Anschluss;Ziel BMK;Ziel Anschluss;mm²;Potential\n"
        "1;-K1;A1;-X1;1;1,5;24V\n",
        [("1", "-K1:A1", "-X1:1", "BK", 1.5, None)],
        ["Potential"],
    ),
    "a German cabinet with ferrules": (
        "lfd. Nr.;BMK Start;Klemme Start;BMK Ziel;Klemme Ziel;Aderquerschnitt mm²;Aderfarbe;"
        "Drahtlänge [mm];Aderendhülse Start;Aderendhülse Ziel\n"
        "2;-Q1;4;-K3;A2;1,5;dunkelblau;435;AEH 1,5/8;\n",
        [("W1", "-Q1:4", "-K3:A2", "DB", 1.5, 0.435)],
        ["lfd. Nr.", "Aderendhülse Start", "Aderendhülse Ziel"],
    ),
    "German compounds of conductor": (
        "Potential;Quelle BMK;Quelle Anschluss;Ziel BMK;Ziel Anschluss;Leiterquerschnitt;"
        "Leiterfarbe;Verlegelänge (m)\n"
        "24V;-F1;1;-X1;1;0,75 qmm;dunkelblau;0,45\n"
        "24V;-X1;2;-K1;A1;0,75 qmm;dunkelblau;0,62\n",
        [
            ("24V", "-F1:1", "-X1:1", "DB", 0.75, 0.45),
            ("24V#2", "-X1:2", "-K1:A1", "DB", 0.75, 0.62),
        ],
        [],
    ),
    "avionics": (
        "Wire ID;Gage;Colour Code;From Ref Des;From Pin No.;From Contact P/N;To Ref Des;"
        "To Pin No.;To Contact P/N;Est Length in;Shield\n"
        "EV22-0002;22;WHT/BLU;J101;B;M39029/58;P202;15;M39029/58;44.5;SH1\n",
        [("EV22-0002", "J101:B", "P202:15", "WHBU", 0.326, 1.1303)],
        ["From Contact P/N", "To Contact P/N", "Shield"],
    ),
    "ways of plugs": (
        "#,Signal Name,Plug A,Way A,Plug B,Way B,Wire csa (mm2),Wire Colour,Cut Length / mm,"
        "Sleeve\n"
        "1,IGN,DTM06-4S,1,DTM04-4P,1,0.5,pink,640,\n",
        [("1", "DTM06-4S:1", "DTM04-4P:1", "PK", 0.5, 0.64)],
        ["Signal Name", "Sleeve"],
    ),
    "a boat, with panels and terminal blocks": (
        "Circuit ID,Origin Panel,Origin Terminal Block,Origin Point,Dest. Panel,"
        "Destination Terminal Block,Dest. Point,Conductor Size,Insulation Colour,"
        "Run Length (ft),Function\n"
        "C-102,P1,TB1,2,P2,TB7,13,16 AWG,Yellow w/ Red,9.5,Bilge\n",
        [("C-102", "TB1:2", "TB7:13", "YERD", 1.31, 2.8956)],
        ["Origin Panel", "Dest. Panel", "Function"],
    ),
    "equipment and square millimetres": (
        "Wire Ref,Eqpt From,Term From,Eqpt To,Term To,Size mm sq,Colour,Core No,Cable Ref\n"
        "W1,K1,11,TB1,1,2.5,grey,1,CB1\n"
        "W3,K2,11,TB1,3,1.5,blue,,\n",
        [("W1", "K1:11", "TB1:1", "GY", 2.5, None), ("W3", "K2:11", "TB1:3", "BU", 1.5, None)],
        [],
    ),
    "circuits of housings below titles": (
        "Machine harness rev B,,,,,,\n"
        "printed 2026-02-01,,,,,,\n"
        ",,,,,,\n"
        "Lead No,Start Housing,Start Circuit,End Housing,End Circuit,Wire Gauge & Type,"
        "Wire Color,Finished Length (mm)\n"
        "1,H1,1,H2,1,20 AWG UL1007,Orange,250\n",
        [("1", "H1:1", "H2:1", "OG", 0.518, 0.25)],
        [],
    ),
    "a Spanish loom with initial and final ends": (
        "Cable nº;Conector inicial;Cavidad;Conector final;Cavidad;Calibre AWG;Color;"
        "Largo total (m)\n"
        "C1;X1;1;X2;1;20;rojo;1,2\n",
        [("C1", "X1:1", "X2:1", "RD", 0.518, 1.2)],
        [],
    ),
    "French points A and B": (
        "Repère;Composant A;Point A;Composant B;Point B;Calibre (AWG);Coloris\n"
        "10;BP1;13;X1;1;20;bleu\n",
        [("10", "BP1:13", "X1:1", "BU", 0.518, None)],
        [],
    ),
    "Italian positions after each connector": (
        "Conduttore;Dal connettore;Pos.;Al connettore;Pos.;Sez.;Col.;Lungh. (cm)\n"
        "W2;J1;2;J2;2;0,75;giallo/verde;32\n",
        [("W2", "J1:2", "J2:2", "GNYE", 0.75, 0.32)],
        [],
    ),
    "an Italian pin list": (
        "Connettore;Piedino;Filo;Colore;Sezione\nJ1;1;F1;rosso;0,5\nJ2;1;F1;rosso;0,5\n",
        [("F1", "J1:1", "J2:1", "RD", 0.5, None)],
        [],
    ),
    "an Italian cabinet": (
        "N. filo;Apparecchio partenza;Morsetto partenza;Apparecchio arrivo;Morsetto arrivo;"
        "Sezione mmq;Colore conduttore;Lunghezza taglio mm\n"
        "1;QF1;2;KM1;A1;1,5;azzurro;410\n",
        [("1", "QF1:2", "KM1:A1", "BU", 1.5, 0.41)],
        [],
    ),
    "a diameter in square millimetres": (
        "Verb.-Nr.;Betriebsmittel A;Anschluss A;Betriebsmittel B;Anschluss B;Ø mm²;Farbcode;"
        "Länge;Leitungstyp\n"
        "1;-K1;A1;-X1;1;1;BU;300;H05V-K\n",
        [("1", "-K1:A1", "-X1:1", "BU", 1.0, 0.3)],
        ["Leitungstyp"],
    ),
    "Klemme as Kl.": (
        "Pos;Von Gerät;Von Kl.;Nach Gerät;Nach Kl.;Querschn.;Farbe;Länge in mm;Hülse\n"
        "1;F1;1;K1;13;0,75;rot;200;6mm\n",
        [("W1", "F1:1", "K1:13", "RD", 0.75, 0.2)],
        ["Pos", "Hülse"],
    ),
    "lengths to strip beside whole ends": (
        "Item,Part #,Wire Type,Strip A,Strip B,End A,End A Pin,End B,End B Pin,Length,Color,"
        "Marker A,Marker B\n"
        "1,MW-20,PVC,5,5,X1,1,X4,2,350,RD,X1:1,X4:2\n",
        [("W1", "X1:1", "X4:2", "RD", 2.5, 0.35)],
        ["Item", "Part #", "Wire Type", "Strip A", "Strip B", "Marker A", "Marker B"],
    ),
    "Spanish circuits and seals": (
        "Conector A;Terminal A;Conector B;Terminal B;Calibre;Color;Long. (cm);Sello A;Circuito\n"
        "P1;1;P2;1;20;rosa;40;S1;C10\n",
        [("C10", "P1:1", "P2:1", "PK", 0.518, 0.4)],
        [],
    ),
    "a French target": (
        "Numéro;Source;Borne source;Cible;Borne cible;Sect.;Coul.;Long. mm;Observations\n"
        "1;QF1;1;KA1;A1;1,5;bleu clair;330;\n",
        [("1", "QF1:1", "KA1:A1", "BU", 1.5, 0.33)],
        ["Observations"],
    ),
    "French seals": (
        "Equipement A;Contact A;Equipement B;Contact B;Fil n°;Jauge;Couleur;Longueur;Joint A\n"
        "P1;A;P2;A;F1;22;blanc;600;J-1\n",
        [("F1", "P1:A", "P2:A", "WH", 0.326, 0.6)],
        [],
    ),
}


@pytest.mark.parametrize("name", LISTS)
def test_a_list_is_read_and_no_column_is_lost_without_a_word(name):
    text, wires, unused = LISTS[name]
    imported = read(text)
    assert rows(imported) == wires
    assert [item.source for item in imported.account.unused_columns] == [
        f"column {heading!r}" for heading in unused
    ]
    assert not [line for line in imported.account.assumptions if "no terminal of" in line]


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("dunkelrot", "RD"),
        ("light blue", "BU"),
        ("bleu clair", "BU"),
        ("white/light blue", "WHBU"),
        ("#1010ff", "BU"),
        ("gris claro", "GY"),
    ],
)
def test_a_shade_of_a_colour_is_reported(text, code):
    imported = read(f"From,To,Colour\nA:1,B:1,{text}\n")
    assert imported.order.wires[0].colour == code
    assert f"line 2: colour {text!r} read as {code}" in imported.account.assumptions
    unknown = read("From,To,Colour\nA:1,B:1,light ochre\n")
    assert unknown.account.unknown_colours == (
        "line 2: colour 'light ochre' is no known colour, BK taken",
    )
    assert not imported.account.unknown_colours
