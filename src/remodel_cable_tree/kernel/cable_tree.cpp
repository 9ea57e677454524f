#include "cable_tree.hpp"

#include <algorithm>

namespace remodel {

Precedence::Precedence(int ends)
    : ends_(ends), words_((ends + 63) / 64), after_(ends * words_), before_(ends * words_) {}

bool Precedence::add(int a, int b) {
  if (a == b || before(b, a)) return false;
  if (before(a, b)) return true;
  // All that come before a, and a itself, come before b and all that come after b.
  std::vector<int> earlier{a}, later{b};
  for (int end = 0; end < ends_; ++end) {
    if (before(end, a)) earlier.push_back(end);
    if (before(b, end)) later.push_back(end);
  }
  for (int end : earlier) {
    std::uint64_t* row = &after_[end * words_];
    for (int word = 0; word < words_; ++word) row[word] |= after_[b * words_ + word];
    row[b / 64] |= 1ull << (b % 64);
  }
  for (int end : later) {
    std::uint64_t* row = &before_[end * words_];
    for (int word = 0; word < words_; ++word) row[word] |= before_[a * words_ + word];
    row[a / 64] |= 1ull << (a % 64);
  }
  return true;
}

CableTree::CableTree(const CableTreeTables& tables)
    : t(tables), direct(t.ends), disjunctives_of(t.ends),
      soft(static_cast<std::size_t>(t.ends) * t.ends) {
  for (int i = 0; i < t.directs; ++i) direct[t.direct[i]] = 1;
  for (int i = 0; i < t.disjunctives; ++i)
    for (int j = 0; j < 4; ++j) {
      std::vector<int>& list = disjunctives_of[t.disjunctive[4 * i + j]];
      if (list.empty() || list.back() != i) list.push_back(i);
    }
  for (int i = 0; i < t.softs; ++i) {
    const int a = t.soft[2 * i], b = t.soft[2 * i + 1];
    soft[static_cast<std::size_t>(a) * t.ends + b] += 1;
    soft[static_cast<std::size_t>(b) * t.ends + a] -= 1;
  }
}

namespace {

// Depth-first search over what propagation leaves open: first the directions of the cables whose
// ends must follow each other, then the disjunctions that an order at hand breaks.
class FeasibilitySearch {
 public:
  FeasibilitySearch(const CableTree& tree, std::int64_t most_nodes, int* order)
      : tree_(tree), t_(tree.t), nodes_left_(most_nodes), order_(order), together_(tree.t.cables) {
    for (int cable = 0; cable < t_.cables; ++cable)
      together_[cable] = tree.direct[cable] && tree.direct[cable + t_.cables];
  }

  // Ask for the ends of as many cables as possible, taken in a given order, to follow each other.
  // Leaves the order found for the last cable that was possible; false if there is none.
  bool gather(Precedence known, const std::vector<int>& cables, std::int64_t most_nodes,
              Random& random) {
    bool found = false;
    for (int cable : cables) {
      const bool was = together_[cable];
      int a = cable, b = cable + t_.cables;
      if (random.below(2)) std::swap(a, b);
      together_[cable] = 1;
      bool done = false;
      for (int turn = 0; turn < 2 && !done; ++turn, std::swap(a, b)) {
        Precedence next = known;
        if (!next.add(a, b) || !propagate(next)) continue;
        nodes_left_ = most_nodes;
        done = search(next) == Feasibility::kFound;
        if (done) known = std::move(next);
      }
      if (!done) together_[cable] = was;
      found = found || done;
      if (done) kept_.assign(order_, order_ + t_.ends);
    }
    std::copy(kept_.begin(), kept_.end(), order_);
    return found;
  }

  Feasibility search(Precedence known) {
    if (--nodes_left_ < 0) return Feasibility::kUndecided;
    if (!propagate(known)) return Feasibility::kNone;
    for (int cable = 0; cable < t_.cables; ++cable) {
      const int a = cable, b = cable + t_.cables;
      const bool matters = together_[cable] || tree_.direct[a] || tree_.direct[b];
      if (matters && !known.before(a, b) && !known.before(b, a)) return branch(known, a, b, b, a);
    }
    const int broken = complete(known);
    if (broken < 0) return Feasibility::kFound;
    const std::int32_t* d = t_.disjunctive + 4 * broken;
    return branch(known, d[0], d[1], d[2], d[3]);
  }

  // Draw all conclusions. False on a contradiction.
  bool propagate(Precedence& known) const {
    for (bool changed = true; changed;) {
      changed = false;
      for (int i = 0; i < t_.disjunctives; ++i) {
        const std::int32_t* d = t_.disjunctive + 4 * i;
        if (!conclude(known, d[0], d[1], d[2], d[3], changed)) return false;
      }
      for (int cable = 0; cable < t_.cables; ++cable) {
        const int a = cable, b = cable + t_.cables;
        const bool follows = together_[cable] || (tree_.direct[a] && known.before(a, b)) ||
                             (tree_.direct[b] && known.before(b, a));
        if (follows && !keep_together(known, a, b, changed)) return false;
      }
    }
    return true;
  }

 private:
  Feasibility branch(const Precedence& known, int a, int b, int c, int d) {
    bool undecided = false;
    const int choices[2][2] = {{a, b}, {c, d}};
    for (const auto& choice : choices) {
      Precedence next = known;
      if (!next.add(choice[0], choice[1])) continue;
      const Feasibility result = search(std::move(next));
      if (result == Feasibility::kFound) return result;
      undecided = undecided || result == Feasibility::kUndecided;
    }
    return undecided ? Feasibility::kUndecided : Feasibility::kNone;
  }

  // Where one part of a disjunction is impossible, the other one holds.
  bool conclude(Precedence& known, int a, int b, int c, int d, bool& changed) const {
    const bool not_first = a == b || known.before(b, a);
    const bool not_second = c == d || known.before(d, c);
    if (not_first && not_second) return false;
    if (not_first && !known.before(c, d)) {
      changed = true;
      return known.add(c, d);
    }
    if (not_second && !known.before(a, b)) {
      changed = true;
      return known.add(a, b);
    }
    return true;
  }

  // What comes before one of two neighbours comes before the other, and likewise after.
  bool keep_together(Precedence& known, int a, int b, bool& changed) const {
    std::vector<std::pair<int, int>> found;
    for (int turn = 0; turn < 2; ++turn, std::swap(a, b)) {
      known.each_after(a, b, [&](int end) { if (end != b) found.emplace_back(b, end); });
      known.each_before(a, b, [&](int end) { if (end != b) found.emplace_back(end, b); });
    }
    for (const auto& [first, second] : found) {
      if (known.before(first, second)) continue;
      if (!known.add(first, second)) return false;
      changed = true;
    }
    return true;
  }

  // Write an order that satisfies what is known; return a disjunction that it breaks, or -1.
  int complete(const Precedence& known) {
    std::vector<int> place(t_.ends, -1);
    int count = 0;
    const auto put = [&](int end) {
      place[end] = count;
      order_[count++] = end;
    };
    const auto ready = [&](int end) {
      if (place[end] >= 0) return false;
      for (int other = 0; other < t_.ends; ++other)
        if (place[other] < 0 && known.before(other, end)) return false;
      return true;
    };
    while (count < t_.ends) {
      int end = 0;
      while (!ready(end)) ++end;
      put(end);
      const int other = tree_.other_end(end);
      if (other < 0 || place[other] >= 0) continue;
      if (tree_.direct[end] || together_[std::min(end, other)]) put(other);
    }
    for (int i = 0; i < t_.disjunctives; ++i) {
      const std::int32_t* d = t_.disjunctive + 4 * i;
      if (place[d[0]] >= place[d[1]] && place[d[2]] >= place[d[3]]) return i;
    }
    return -1;
  }

  const CableTree& tree_;
  const CableTreeTables& t_;
  std::int64_t nodes_left_;
  int* order_;
  std::vector<int> kept_;
  std::vector<char> together_;   // by cable: its ends are asked to follow each other
};

}  // namespace

bool draw_conclusions(const CableTree& tree, Precedence& known) {
  for (int i = 0; i < tree.t.atomics; ++i)
    if (!known.add(tree.t.atomic[2 * i], tree.t.atomic[2 * i + 1])) return false;
  return FeasibilitySearch(tree, 0, nullptr).propagate(known);
}

Feasibility find_order(const CableTree& tree, const Precedence& known, std::int64_t most_nodes,
                       int* order) {
  return FeasibilitySearch(tree, most_nodes, order).search(known);
}

bool gather_cables(const CableTree& tree, Precedence known, std::int64_t most_nodes, Random& random,
                   int* order) {
  std::vector<int> cables(tree.t.cables);
  for (int i = 0; i < tree.t.cables; ++i) cables[i] = i;
  for (int i = tree.t.cables - 1; i > 0; --i) std::swap(cables[i], cables[random.below(i + 1)]);
  // Ends that bind their cable leave the least choice, and go first.
  std::stable_partition(cables.begin(), cables.end(), [&tree](int cable) {
    return tree.direct[cable] || tree.direct[cable + tree.t.cables];
  });
  FeasibilitySearch search(tree, most_nodes, order);
  return search.gather(std::move(known), cables, most_nodes, random);
}

}  // namespace remodel
