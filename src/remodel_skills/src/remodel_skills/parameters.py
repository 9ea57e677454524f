"""The numbers of the skills, as data: `parameters/*.yaml` say what each means and where it is from.

A field's name ends with its unit, in SI: `_m`, `_s`, `_n`, `_rad`, `_m_s`; without one it is a
share, a ratio or a count. What follows from others is computed here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from remodel_work.panel import PanelWire


@dataclass(frozen=True)
class ToolParameters:
    """What the hand and its fingers decide: parameters/tool.yaml."""

    open_m: float
    finger_beyond_m: float
    hand_corner_m: float
    arm_reach_m: float
    floor_clearance_m: float
    led_floor_clearance_m: float
    pads_clear_m: float
    before_face_m: float
    slow_before_m: float
    wire_in_grip_m: float
    close_timeout_s: float
    fingers_still_m: float
    fingers_still_s: float
    open_speed_m_s: float
    release_opening_m: float
    least_opening_m: float
    clear_of_neighbours_m: float
    missed_share: float
    blocked_m: float
    held_load_n: float
    least_push_n: float
    grip_holds_n: float
    grip_holds_connector_n: float
    grasp_distance_range_m: tuple[float, float]
    eyelet_apart_m: float
    eyelet_closed_m: float
    eyelet_closed_share: float
    eyelet_step_down_m: float
    eyelet_attempts: int
    eyelet_attempts_seen: int

    @property
    def finger_room_m(self) -> float:
        """How far an open finger reaches to the side of the wire [m]."""
        return self.open_m + self.finger_beyond_m


@dataclass(frozen=True)
class WireParameters:
    """What a wire decides: parameters/wire.yaml."""

    grip_stiffness_n_m: float
    clamped_stiffness_n_m: float
    sagging_stiffness_n_m: float
    tightest_bend_m: float
    snag_n: float
    snag_s: float
    taut_n: float
    most_taut_n: float
    tuck_most_n: float
    free_way_n: float
    gives_way_from_n: float
    gives_way_by_n: float
    rubs_n: float
    feel_n: float
    gentle_above_n: float
    ferrule_askew_rad: float
    buckles_within_m: float
    pull_travel_m: float
    taken_up_share: float
    slack_shares: tuple[float, ...]
    slack_most_share: float
    slack_up_rad: tuple[float, ...]
    steep_shares: tuple[float, ...]
    steep_most_share: float
    steep_up_rad: tuple[float, ...]
    flat_shares: tuple[float, ...]
    flat_most_share: float
    flat_up_rad: tuple[float, ...]
    straight_share: float
    lifted_share: float
    pin_slack_range_m: tuple[float, float]
    path_space_range_m: tuple[float, float]
    connector_space_range_m: tuple[float, float]
    path_tolerance_m: float

    def most_at_face_n(self, wire: PanelWire) -> float:
        """Return with how much an end may be pushed while its tip may be beside the opening [N].

        A ferrule that stands askew by an angle a bends at its joint with the wire where the moment
        of the push about the joint, F L sin(a), reaches the wire's yield moment, EI k: beyond the
        curvature k its strands' outer fibres yield (remodel_msgs/config/wire_materials.yaml).
        """
        lever = wire.ferrule_length * math.sin(self.ferrule_askew_rad)
        bends_n = wire.bending_stiffness * wire.yield_curvature / lever
        return min(self.gentle_above_n, bends_n)

    def snagged_n(self, bending_stiffness: float) -> float:
        """Return the pull of a wire that hangs on something [N]: more than that of a free one.

        A free one pulls with no more than its bending stiffness [N m^2] over the square of its
        tightest bend's radius: the bending moment of a rod is B / r (Euler and Bernoulli), and
        it acts over a lever of about r.
        """
        return self.snag_n + bending_stiffness / self.tightest_bend_m**2


@dataclass(frozen=True)
class TerminalParameters:
    """What a terminal decides, and a connector's header: parameters/terminal.yaml."""

    neighbour_within_m: float
    face_m: float
    gentle_before_m: float
    slow_before_m: float
    home_before_m: float
    overtravel_m: float
    short_of_bottom_m: float
    beyond_bottom_m: float
    slid_m: float
    turned_in_m: float
    feels_m: tuple[float, ...]
    yields_aside_m: float
    yields_up_m: float
    already_there_m: float
    already_there_rad: float
    out_m: float
    pushed_in_holds_n: float
    max_slip_m: float
    lead_pull_share: float
    connector_stiffness_n_m: float
    short_of_face_m: float
    latch_pull_n: float
    pin_tolerance_m: float
    level_rad: float
    socket_tolerance_m: float
    opening_tolerance_m: float
    opening_tolerance_rad: float


@dataclass(frozen=True)
class FixtureParameters:
    """What clips, ducts, forks and the feeder decide: parameters/fixture.yaml."""

    clip_slack_m: float
    clip_clear_m: float
    clip_above_wire_m: float
    clip_lips_within_m: float
    clip_above_lips_m: float
    clip_beside_ratio: float
    clip_excess_ratio: float
    clip_rises_m: tuple[float, ...]
    duct_corner_m: float
    duct_turned_shares: tuple[float, float]
    duct_straight_again_m: float
    duct_over_rim_m: float
    duct_under_rim_m: float
    duct_rises_m: float
    duct_inward_rad: float
    duct_least_held_m: float
    duct_hidden_m: float
    duct_onward_m: float
    duct_lower_m: float
    duct_room_m: float
    duct_back_m: float
    duct_asides_m: tuple[float, ...]
    duct_shed_over_m: float
    duct_enough_share: float
    duct_least_share: float
    duct_walls_m: float
    duct_short_share: float
    tuck_loop_m: float
    tuck_corner_m: float
    tuck_over_rim_m: float
    tuck_graspable_m: float
    tuck_down_m: float
    tuck_over_travel_m: float
    fork_over_posts_m: float
    fork_highest_m: float
    fork_sink_m: float
    fork_over_component_m: float
    feeder_fork_tolerance_m: float
    feeder_fork_away_m: tuple[float, float]


@dataclass(frozen=True)
class MotionParameters:
    """How fast arms go, how high, and what they keep clear of: parameters/motion.yaml."""

    free_speed_m_s: float
    carry_speed_m_s: float
    approach_speed_m_s: float
    lift_speed_m_s: float
    clear_speed_m_s: float
    lead_speed_m_s: float
    leave_speed_m_s: float
    hold_speed_m_s: float
    swing_speed_m_s: float
    press_speed_m_s: float
    lips_speed_m_s: float
    opening_speed_m_s: float
    wire_inside_speed_m_s: float
    wire_home_speed_m_s: float
    connector_inside_speed_m_s: float
    connector_home_speed_m_s: float
    pull_speed_m_s: float
    test_speed_m_s: float
    tighten_speed_m_s: float
    draw_speed_m_s: float
    wire_turn_rate_rad_s: float
    acceleration_m_s2: float
    travel_z_m: float
    lift_z_m: tuple[float, ...]
    carry_z_m: float
    both_carry_z_m: float
    approach_z_m: float
    approach_above_m: float
    lift_above_m: float
    clear_of_wire_m: float
    above_target_m: float
    let_down_above_m: float
    low_carry_m: float
    drawn_up_heights: int
    tighten_m: float
    draw_m: float
    still_s: float
    force_still_s: float
    settled_s: float
    pick_up_attempts: int
    clip_attempts: int
    clip_presses: int
    tucks: int
    tucks_of_refused: int
    check_step_m: float
    check_step_rad: float
    joint_check_step_rad: float
    rate_samples: int
    tracking_tolerance_m: float
    most_lag_m: float
    arrived_m: float
    robots_apart_m: float
    holding_apart_m: float
    around_m: tuple[float, ...]
    wait_limit_s: float
    wait_s: float
    hold_aside_rad: tuple[float, ...]
    most_aside_rad: float
    hold_z_m: tuple[float, float]
    hold_way_cost: float
    hold_up_cost: float
    force_time_constant_s: float
    force_aims_above_share: float
    force_acceleration_m_s2: float
    force_pressed_share: float
    stalled_m: float
    stalled_s: float
    derivative_step_m: float

    @property
    def lifts_z_m(self) -> tuple[float, ...]:
        """Heights over which a motion goes that is blocked lower, the lowest first [m]."""
        return (self.travel_z_m, *self.lift_z_m)


@dataclass(frozen=True)
class LookingParameters:
    """Where cameras are placed, and what decides what they have seen: parameters/looking.yaml."""

    camera_z_m: float
    diagonal_z_m: float
    far_z_m: float
    end_aside_m: tuple[tuple[float, float], ...]
    end_far_m: float
    label_aside_m: tuple[tuple[float, float], ...]
    label_far_m: float
    diagonal_share: float
    lens_at_m: tuple[tuple[float, float], ...]
    held_turns_rad: tuple[float, ...]
    held_turn_steps: int
    held_reach_m: tuple[float, float]
    held_step_m: float
    held_turn_cost_m: float
    views_apart_m: float
    most_views: int
    views_per_observation: int
    enough_views: int
    border_px: float
    device_in_view_share: float
    sight_radius_m: float
    aside_z_m: float
    out_of_sight_m: tuple[float, ...]
    aside_directions: int
    drawn_m: float
    same_tip_m: float
    held_tip_m: float
    held_tip_height_m: float
    places_between_pads: int
    least_seen_m: float
    beside_clip_m: float
    clip_search_m: float
    clip_aside_m: float
    clip_above_m: float
    duct_search_m: float
    slot_search_m: float
    slot_turn_rad: float
    tuck_search_m: float
    direction_m: float
    beyond_posts_m: tuple[float, float]
    across_fork_m: float
    least_points: int
    displaced_m: float
    displaced_rad: float


@dataclass(frozen=True)
class Parameters:
    """All numbers of the skills.

    Attributes:
        tool: what hand and fingers decide.
        wire: what a wire decides.
        terminal: what a terminal decides, and a connector's header.
        fixture: what clips, ducts, forks and the feeder decide.
        motion: speeds, heights, times, and what motions keep clear of.
        looking: where cameras are placed, and what decides what they have seen.
    """

    tool: ToolParameters
    wire: WireParameters
    terminal: TerminalParameters
    fixture: FixtureParameters
    motion: MotionParameters
    looking: LookingParameters
