"""Write a problem as HDDL: PDDL's actions, with the tasks and methods that guide them.

Any order of the wires can be decomposed; in which they are placed is the planner's choice.
"""

from __future__ import annotations

from remodel_pddl.pddl import (
    ACTIONS,
    DOMAIN,
    FUNCTIONS,
    PREDICATES,
    TYPES,
    initial,
    objects,
    requirements,
)
from remodel_pddl.symbolic import Symbols

_TASKS = """\
  (:task wire-all :parameters ())
  (:task lay-wire :parameters (?w - wire))
  (:task equip :parameters (?t - tool))
  (:task resolve :parameters (?w - wire))
  (:task put-in :parameters (?w - wire ?e - end))"""

_METHODS = """\
  (:method wire-next
    :parameters (?w - wire)
    :task (wire-all)
    :precondition (stored ?w)
    :ordered-subtasks (and (lay-wire ?w) (wire-all)))
  (:method wired
    :parameters ()
    :task (wire-all)
    :precondition (forall (?w - wire) (fixed ?w))
    :ordered-subtasks (and))
  (:method lay-heavy
    :parameters (?w - wire ?t - tool ?l - predecessor ?p - place ?f - phase ?e ?o - end ?q - place)
    :task (lay-wire ?w)
    :precondition (and (heavy ?w) (needs ?w ?t) (may-start ?w ?e) (other ?e ?o) (end-at ?w ?o ?q))
    :ordered-subtasks (and (equip ?t) (pick-heavy ?w ?t ?l ?p ?f) (resolve ?w) (aim ?w ?e)
      (put-in ?w ?e) (route ?w ?e ?o) (put-in ?w ?o) (fix ?w ?o ?q)))
  (:method lay-light
    :parameters (?w - wire ?t - tool ?l - predecessor ?p - place ?f - phase ?e ?o - end ?q - place)
    :task (lay-wire ?w)
    :precondition (and (light ?w) (needs ?w ?t) (may-start ?w ?e) (other ?e ?o) (end-at ?w ?o ?q))
    :ordered-subtasks (and (equip ?t) (pick-light ?w ?t ?l ?p ?f) (resolve ?w) (aim ?w ?e)
      (put-in ?w ?e) (route ?w ?e ?o) (put-in ?w ?o) (fix ?w ?o ?q)))
  (:method equipped
    :parameters (?t - tool)
    :task (equip ?t)
    :precondition (has-tool ?t)
    :ordered-subtasks (and))
  (:method equip-again
    :parameters (?p - place ?old ?new - tool)
    :task (equip ?new)
    :precondition (and (at ?p) (has-tool ?old) (not (= ?old ?new)))
    :ordered-subtasks (and (change-tool ?p ?old ?new)))
  (:method resolve-kept
    :parameters (?s - soft-order ?before ?w - wire)
    :task (resolve ?w)
    :precondition (and (soft-order-of ?s ?before ?w) (open ?s) (picked ?before))
    :ordered-subtasks (and (keep-soft-order ?s ?before ?w) (resolve ?w)))
  (:method resolve-violated
    :parameters (?s - soft-order ?before ?w - wire)
    :task (resolve ?w)
    :precondition (and (soft-order-of ?s ?before ?w) (open ?s) (stored ?before))
    :ordered-subtasks (and (violate-soft-order ?s ?before ?w) (resolve ?w)))
  (:method resolve-all
    :parameters (?w - wire)
    :task (resolve ?w)
    :ordered-subtasks (and (take ?w)))
  (:method put-in-first
    :parameters (?w - wire ?e - end ?c - component)
    :task (put-in ?w ?e)
    :precondition (and (aimed ?w ?e) (part-of ?w ?e ?c) (located ?c))
    :ordered-subtasks (and (insert-first ?w ?e ?c)))
  (:method look-and-put-in-first
    :parameters (?w - wire ?e - end ?c - component)
    :task (put-in ?w ?e)
    :precondition (and (aimed ?w ?e) (part-of ?w ?e ?c) (unlocated ?c))
    :ordered-subtasks (and (locate ?c ?w ?e) (insert-first ?w ?e ?c)))
  (:method put-in-second
    :parameters (?w - wire ?e - end ?c - component)
    :task (put-in ?w ?e)
    :precondition (and (routed ?w) (part-of ?w ?e ?c) (located ?c))
    :ordered-subtasks (and (insert-second ?w ?e ?c)))
  (:method look-and-put-in-second
    :parameters (?w - wire ?e - end ?c - component)
    :task (put-in ?w ?e)
    :precondition (and (routed ?w) (part-of ?w ?e ?c) (unlocated ?c))
    :ordered-subtasks (and (locate ?c ?w ?e) (insert-second ?w ?e ?c)))"""


def domain_text(*, has_numeric_fluents: bool = False) -> str:
    """Return the domain, which is the same for all problems; arguments as of pddl.domain_text."""
    stated = requirements(has_numeric_fluents=has_numeric_fluents)
    return "\n".join(
        (
            f"(define (domain {DOMAIN})",
            f"  (:requirements {stated} :hierarchy :method-preconditions)",
            TYPES,
            PREDICATES,
            FUNCTIONS,
            _TASKS,
            _METHODS,
            ACTIONS,
            ")\n",
        )
    )


def problem_text(symbols: Symbols) -> str:
    """Return a problem: all wires are to be placed."""
    return "\n".join(
        (
            f"(define (problem {symbols.name})",
            f"  (:domain {DOMAIN})",
            "  (:objects",
            *objects(symbols),
            "  )",
            "  (:htn",
            "    :ordered-subtasks (and (wire-all)))",
            "  (:init",
            *initial(symbols),
            "  )",
            "  (:metric minimize (total-cost))",
            ")\n",
        )
    )
