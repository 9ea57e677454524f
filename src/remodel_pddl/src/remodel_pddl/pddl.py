"""Write a problem as PDDL with action costs, and plans as PDDL planners print them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from remodel_pddl.symbolic import HEAVY_ONLY, LIGHT_BEGUN, NOTHING, Ground, Symbols

DOMAIN = "remodel-wiring"

# By PDDL 3.1 (Kovacs, BNF), :action-costs alone allows the numeric fluents that costs need.
# Fast Downward refuses :numeric-fluents, and other parsers read no functions without it.
NUMERIC_FLUENTS = ":numeric-fluents"
REQUIREMENTS = (
    ":strips :typing :equality :negative-preconditions :disjunctive-preconditions "
    ":universal-preconditions :action-costs"
)

TYPES = """\
  (:types predecessor component tool place soft-order end phase - object
          wire start - predecessor)
  (:constants nothing - start
              at-start at-station - place
              a b - end
              heavy-only light-begun - phase)"""

PREDICATES = """\
  (:predicates
    (at ?p - place) (last ?l - predecessor) (now ?f - phase) (has-tool ?t - tool) (empty)
    (stored ?w - wire) (picked ?w - wire) (choosing ?w - wire) (held ?w - wire)
    (aimed ?w - wire ?e - end) (in ?w - wire ?e - end) (first-in ?w - wire ?e - end)
    (routed ?w - wire) (going-to ?w - wire ?e - end) (second-in ?w - wire ?e - end)
    (fixed ?w - wire) (located ?c - component) (unlocated ?c - component)
    (open ?s - soft-order) (resolved ?s - soft-order)
    (needs ?w - wire ?t - tool) (heavy ?w - wire) (light ?w - wire) (other ?e ?f - end)
    (end-at ?w - wire ?e - end ?p - place) (part-of ?w - wire ?e - end ?c - component)
    (may-start ?w - wire ?e - end) (soft-order-of ?s - soft-order ?before ?after - wire)
    (under ?before ?after - wire) (pin ?before - wire ?be - end ?after - wire ?ae - end))"""

FUNCTIONS = """\
  (:functions
    (total-cost) - number
    (change-cost ?p - place) - number
    (pick-cost ?l - predecessor ?p - place ?w - wire ?f - phase) - number
    (soft-order-weight ?s - soft-order) - number
    (approach ?w - wire ?e - end) - number
    (look-cost) - number
    (insert-cost ?w - wire ?e - end) - number
    (route-cost ?w - wire) - number
    (fix-cost ?w - wire) - number)"""

ACTIONS = """\
  (:action change-tool
    :parameters (?p - place ?old ?new - tool)
    :precondition (and (empty) (at ?p) (has-tool ?old) (not (= ?old ?new)))
    :effect (and (not (at ?p)) (at at-station) (not (has-tool ?old)) (has-tool ?new)
      (increase (total-cost) (change-cost ?p))))
  (:action pick-heavy
    :parameters (?w - wire ?t - tool ?l - predecessor ?p - place ?f - phase)
    :precondition (and (empty) (stored ?w) (heavy ?w) (needs ?w ?t) (has-tool ?t) (last ?l) (at ?p)
      (now ?f))
    :effect (and (not (empty)) (not (stored ?w)) (picked ?w) (choosing ?w) (not (last ?l)) (last ?w)
      (not (at ?p)) (increase (total-cost) (pick-cost ?l ?p ?w ?f))))
  (:action pick-light
    :parameters (?w - wire ?t - tool ?l - predecessor ?p - place ?f - phase)
    :precondition (and (empty) (stored ?w) (light ?w) (needs ?w ?t) (has-tool ?t) (last ?l) (at ?p)
      (now ?f))
    :effect (and (not (empty)) (not (stored ?w)) (picked ?w) (choosing ?w) (not (last ?l)) (last ?w)
      (not (at ?p)) (not (now heavy-only)) (now light-begun)
      (increase (total-cost) (pick-cost ?l ?p ?w ?f))))
  (:action keep-soft-order
    :parameters (?s - soft-order ?before ?after - wire)
    :precondition (and (choosing ?after) (soft-order-of ?s ?before ?after) (open ?s)
      (picked ?before))
    :effect (and (not (open ?s)) (resolved ?s)))
  (:action violate-soft-order
    :parameters (?s - soft-order ?before ?after - wire)
    :precondition (and (choosing ?after) (soft-order-of ?s ?before ?after) (open ?s)
      (stored ?before))
    :effect (and (not (open ?s)) (resolved ?s) (increase (total-cost) (soft-order-weight ?s))))
  (:action take
    :parameters (?w - wire)
    :precondition (and (choosing ?w) (forall (?s - soft-order ?before - wire)
      (imply (soft-order-of ?s ?before ?w) (resolved ?s))))
    :effect (and (not (choosing ?w)) (held ?w)))
  (:action aim
    :parameters (?w - wire ?e - end)
    :precondition (and (held ?w) (may-start ?w ?e))
    :effect (and (not (held ?w)) (aimed ?w ?e) (going-to ?w ?e)
      (increase (total-cost) (approach ?w ?e))))
  (:action locate
    :parameters (?c - component ?w - wire ?e - end)
    :precondition (and (going-to ?w ?e) (part-of ?w ?e ?c) (unlocated ?c))
    :effect (and (not (unlocated ?c)) (located ?c) (increase (total-cost) (look-cost))))
  (:action insert-first
    :parameters (?w - wire ?e - end ?c - component)
    :precondition (and (aimed ?w ?e) (part-of ?w ?e ?c) (located ?c)
      (forall (?b - wire ?f - end) (imply (pin ?b ?f ?w ?e) (in ?b ?f))))
    :effect (and (not (aimed ?w ?e)) (not (going-to ?w ?e)) (first-in ?w ?e) (in ?w ?e)
      (increase (total-cost) (insert-cost ?w ?e))))
  (:action route
    :parameters (?w - wire ?e ?f - end)
    :precondition (and (first-in ?w ?e) (other ?e ?f)
      (forall (?b - wire) (imply (under ?b ?w) (routed ?b))))
    :effect (and (not (first-in ?w ?e)) (routed ?w) (going-to ?w ?f)
      (increase (total-cost) (route-cost ?w))))
  (:action insert-second
    :parameters (?w - wire ?e - end ?c - component)
    :precondition (and (routed ?w) (going-to ?w ?e) (part-of ?w ?e ?c) (located ?c)
      (forall (?b - wire ?f - end) (imply (pin ?b ?f ?w ?e) (in ?b ?f))))
    :effect (and (not (going-to ?w ?e)) (second-in ?w ?e) (in ?w ?e)
      (increase (total-cost) (insert-cost ?w ?e))))
  (:action fix
    :parameters (?w - wire ?e - end ?p - place)
    :precondition (and (second-in ?w ?e) (end-at ?w ?e ?p))
    :effect (and (not (second-in ?w ?e)) (fixed ?w) (empty) (at ?p)
      (increase (total-cost) (fix-cost ?w))))"""


def requirements(*, has_numeric_fluents: bool) -> str:
    """Return the requirements of the domain."""
    return f"{REQUIREMENTS} {NUMERIC_FLUENTS}" if has_numeric_fluents else REQUIREMENTS


def domain_text(*, has_numeric_fluents: bool = False) -> str:
    """Return the domain, which is the same for all problems.

    Args:
        has_numeric_fluents: whether it states that requirement, too.
    """
    return "\n".join(
        (
            f"(define (domain {DOMAIN})",
            f"  (:requirements {requirements(has_numeric_fluents=has_numeric_fluents)})",
            TYPES,
            PREDICATES,
            FUNCTIONS,
            ACTIONS,
            ")\n",
        )
    )


def problem_text(symbols: Symbols) -> str:
    """Return a problem."""
    goals = " ".join(f"(fixed {wire})" for wire in symbols.objects["wire"])
    return "\n".join(
        (
            f"(define (problem {symbols.name})",
            f"  (:domain {DOMAIN})",
            "  (:objects",
            *objects(symbols),
            "  )",
            "  (:init",
            *initial(symbols),
            "  )",
            f"  (:goal (and {goals}))",
            "  (:metric minimize (total-cost))",
            ")\n",
        )
    )


def plan_text(steps: Sequence[Ground], cost: int) -> str:
    """Return a plan, an action a line, with its cost as Fast Downward notes it."""
    lines = [f"({' '.join(step)})" for step in steps]
    return "\n".join((*lines, f"; cost = {cost} (general cost)")) + "\n"


def objects(symbols: Symbols) -> Iterator[str]:
    """Yield the objects that are no constants of the domain, a type a line."""
    constants = {NOTHING, "at-start", "at-station", HEAVY_ONLY, LIGHT_BEGUN}
    for kind, names in symbols.objects.items():
        own = [name for name in names if name not in constants]
        if own:
            yield f"    {' '.join(own)} - {kind}"


def initial(symbols: Symbols) -> Iterator[str]:
    """Yield what holds at the start, and what actions cost."""
    yield from (f"    ({' '.join(fact)})" for fact in symbols.facts)
    yield "    (= (total-cost) 0)"
    for cost in symbols.costs:
        yield f"    (= ({' '.join(cost.term)}) {cost.value})"
