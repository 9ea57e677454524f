"""Columns that are compressed, since a long run has tens of thousands of similar entries.

An entry starts with the number of its packing. Number 1 is raw deflate with the dictionary below,
which must never change: another one needs another number.
"""

from __future__ import annotations

import json
import zlib

from sqlalchemy import LargeBinary
from sqlalchemy.types import TypeDecorator

_PACKING = b"\x01"
_RAW = -15
_ENCODER = json.JSONEncoder(separators=(",", ":"), ensure_ascii=False)

# What entries have in common; the most frequent comes last, where it costs least.
_DICTIONARY = (
    b'{"form":"1-","state":{"order":"","use_case":"","cell":"","waiting":["W1","W2","W3"]},"task'
    b's":[{"name":"W1","stage":"done","behavior":"Place Wire W1","attempts":1,"connected":["a","'
    b'b"],"outcome":"finished","began_s":1000.0,"cell_s":60.0},{"task":"W1","fault":"insertion_j'
    b'ammed","code":301,"ability":"InsertCable","state_path":"/Connect a/InsertCable","text":"",'
    b'"do":"retry_with","change":[["force_limit",10.0]],"because":"","by":"policy","at_s":1000.0'
    b'}{"task":"W1","attempt":1,"part":"whole","behavior":"Place Wire W1","at_s":1000.0,"chosen"'
    b':[],"chart_hash":"{"task":"W1","outcome":"finished","at_s":1000.0,"placed":true,"path":["/'
    b'Detect","/Connect a/LocateGearboxComponent","/Connect a/PickCable","/Connect a/InsertCable'
    b'","/Connect a/FixCable","/Pick b","/Route b","/Connect b/LocateGearboxComponent","/Connect'
    b' b/InsertCable","/Connect b/FixCable"],"pictures":["W1-1-whole-overhead-.jpg"],"denied":fa'
    b'lse}{"task":"W1","operation":{"state_path":"/Connect b/FixCable","ability":"FixCable","out'
    b'come":"fixed","error_code":0,"text":"the end withstood the pull","ended_s":1000.0,"elapsed'
    b'_s":2.0,"goal_id":"17:","parameters":[["robot_name","robot_1"],["cable_id","W1"],["compone'
    b'nt_id","Q1"],["terminal_id","B1"],["pull_test_force","10.0"],["timeout","30.0"]],"measurem'
    b'ents":[["slip","0.000"]]}}"ability":"DetectCable","outcome":"detected","view","0"],["grasp'
    b'_pose","world 0.4 -0.1 0.05 0 0 0 1"],["grip_width","0.002"]]}}"ability":"RouteWire","outc'
    b'ome":"routed","reached","2"]]}}"ability":"LocateGearboxComponent","outcome":"located","par'
    b'ameters":[["component_id","Q1"],["terminal_id","B1"],["view","0"],["timeout","30.0"]],"mea'
    b'surements":[["component_pose","world 0.4 0.1 0.05 0 0 0.7071 0.7071"],["socket_pose","worl'
    b'd 0.4 0.1 0.05 0 0 0.7071 0.7071"],["residual","0.0004"]]}}{"task":"W1","operation":{"stat'
    b'e_path":"/Connect a/InsertCable","ability":"InsertCable","outcome":"inserted","error_code"'
    b':0,"text":"","ended_s":1000.0,"elapsed_s":4.0,"goal_id":"17:","parameters":[["robot_name",'
    b'"robot_1"],["cable_id","W1"],["cable_end","a"],["component_id","Q1"],["terminal_id","T1"],'
    b'["socket_pose","panel 0.1 0.1 0.05 0 0 0.7071 0.7071"],["force_limit","8.0"],["timeout","3'
    b'0.0"]],"measurements":[["depth","0.009"],["peak_force","6.5"]]}}'
)


def packed(text: str) -> bytes:
    """Return a text compressed."""
    deflate = zlib.compressobj(6, zlib.DEFLATED, _RAW, zdict=_DICTIONARY)
    return _PACKING + deflate.compress(text.encode()) + deflate.flush()


def unpacked(data: bytes) -> str:
    """Return the text that was compressed.

    Raises:
        zlib.error: if the data are damaged, or have an unknown packing.
    """
    if data[:1] != _PACKING:
        raise zlib.error(f"unknown packing {data[:1]!r}")
    inflate = zlib.decompressobj(_RAW, zdict=_DICTIONARY)
    text = inflate.decompress(data[1:]) + inflate.flush()
    if not inflate.eof:
        raise zlib.error("the entry is cut short")
    return text.decode()


def packed_json(value: object) -> bytes:
    """Return plain data compressed."""
    return packed(_ENCODER.encode(value))


class PackedText(TypeDecorator):
    """A text, compressed."""

    impl = LargeBinary
    cache_ok = True

    def process_bind_param(self, value: str | None, _: object) -> bytes | None:
        """Compress what is stored."""
        return None if value is None else packed(value)

    def process_result_value(self, value: bytes | None, _: object) -> str | None:
        """Expand what is read."""
        return None if value is None else unpacked(bytes(value))


class PackedJson(TypeDecorator):
    """Plain data, as compressed JSON."""

    impl = LargeBinary
    cache_ok = True

    def process_bind_param(self, value: object, _: object) -> bytes | None:
        """Compress what is stored."""
        return None if value is None else packed_json(value)

    def process_result_value(self, value: bytes | None, _: object) -> object:
        """Expand what is read."""
        return None if value is None else json.loads(unpacked(bytes(value)))
