// A tree of boxes over points in space: the nearest neighbours of places, and all within a radius of them.
//
// Points are halved across their longest side until leaves of 32 are left; eight boxes in a row share a box above
// them, up to one group of boxes.
// Distances are sums of squares in the order of the axes, without fused products: a box is never further than
// what lies in it, to the last bit.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace topple {

constexpr int LEAF = 32;  // points of a leaf
constexpr int FAN = 8;    // boxes of a group
constexpr int LEVELS = 12;
constexpr double FAR = std::numeric_limits<double>::infinity();

struct Group {  // of eight boxes
    double lower[3][FAN], upper[3][FAN];
};

struct Leaf {
    double at[3][LEAF];
    int32_t row[LEAF];  // -1 behind the last point
};

struct Shape {  // of a tree: how many boxes each level has, and its first group
    int levels = 0;
    int64_t boxes[LEVELS], first[LEVELS + 1];

    explicit Shape(int64_t points) {
        int64_t count = (points + LEAF - 1) / LEAF;
        first[0] = 0;
        do {
            const int64_t groups = (count + FAN - 1) / FAN;
            boxes[levels] = count;
            first[levels + 1] = first[levels] + groups;
            ++levels;
            count = groups;
        } while (count > 1);
    }

    int64_t groups() const { return first[levels]; }
};

struct Entry {  // of a point: where leaves part hangs on no last digit
    float at[3];
    int32_t row;
};

// Halve points across their longest side, again and again, into whole leaves.
inline void halve(Entry *begin, Entry *end) {
    const int64_t leaves = (end - begin + LEAF - 1) / LEAF;
    if (leaves < 2) return;
    constexpr float far = std::numeric_limits<float>::infinity();
    float lower[3] = {far, far, far}, upper[3] = {-far, -far, -far};
    for (const Entry *e = begin; e < end; ++e)
        for (int k = 0; k < 3; ++k) {
            lower[k] = std::min(lower[k], e->at[k]);
            upper[k] = std::max(upper[k], e->at[k]);
        }
    int axis = 0;
    for (int k = 1; k < 3; ++k)
        if (upper[k] - lower[k] > upper[axis] - lower[axis]) axis = k;
    int64_t first = 1;
    while (2 * first < leaves) first *= 2;
    Entry *middle = begin + first * LEAF;
    std::nth_element(begin, middle, end, [axis](const Entry &a, const Entry &b) { return a.at[axis] < b.at[axis]; });
    halve(begin, middle);
    halve(middle, end);
}

// Squares of the distances of a box, or a place where its corners are one, from the boxes of a group.
inline void squares_to(const Group &group, const double *low, const double *high, double *squares) {
    double beside[3][FAN];
    for (int k = 0; k < 3; ++k)
        for (int s = 0; s < FAN; ++s) {
            const double below = group.lower[k][s] - high[k], above = low[k] - group.upper[k][s];
            const double most = below > above ? below : above;
            beside[k][s] = most > 0.0 ? most : 0.0;
        }
    for (int s = 0; s < FAN; ++s)
        squares[s] = beside[0][s] * beside[0][s] + beside[1][s] * beside[1][s] + beside[2][s] * beside[2][s];
}

// Squares of the distances of a place from the points of a leaf.
inline void squares_to(const Leaf &leaf, const double *place, double *squares) {
    for (int s = 0; s < LEAF; ++s) {
        const double x = leaf.at[0][s] - place[0], y = leaf.at[1][s] - place[1], z = leaf.at[2][s] - place[2];
        squares[s] = x * x + y * y + z * z;
    }
}

struct Found {  // a neighbour: of those that are as near the one that comes first in the cloud
    double square;
    int32_t row;
    bool operator<(const Found &other) const {
        return square < other.square || (square == other.square && row < other.row);
    }
};

// Square of the distance of a place from one box of a group.
inline double square_to(const Group &group, int64_t s, const double *place) {
    double square = 0.0;
    for (int k = 0; k < 3; ++k) {
        const double beside = std::max(std::max(group.lower[k][s] - place[k], place[k] - group.upper[k][s]), 0.0);
        square += beside * beside;
    }
    return square;
}

// Write the points of a leaf whose squares from a place are at most a limit, and say where they end: there is
// room for a whole leaf, and what is beyond is written over.
inline Found *points_within(const Leaf &leaf, const double *place, double limit, Found *end) {
    double squares[LEAF];
    squares_to(leaf, place, squares);
    for (int s = 0; s < LEAF; ++s) {
        *end = {squares[s], leaf.row[s]};
        end += squares[s] <= limit && leaf.row[s] >= 0;
    }
    return end;
}

// Keep a neighbour among the nearest, which stay sorted, if it is nearer than the last of them.
inline void insert(const Found &one, std::vector<Found> &best) {
    Found *first = best.data(), *place = first + best.size() - 1;
    if (one.square > place->square || !(one < *place)) return;
    for (; place > first && one < place[-1]; --place) *place = place[-1];
    *place = one;
}

class Tree {
  public:
    Tree(const Leaf *leaves, const Group *groups, int64_t count) : leaves(leaves), groups(groups), shape(count) {
        const Group &top = groups[shape.first[shape.levels - 1]];
        for (int k = 0; k < 3; ++k) {
            whole.lower[k][0] = *std::min_element(top.lower[k], top.lower[k] + FAN);
            whole.upper[k][0] = *std::max_element(top.upper[k], top.upper[k] + FAN);
        }
    }

    // The nearest of a place whose squares are below a limit, or at it with a row before `last`, rising.
    void nearest(const double *place, std::vector<Found> &best, double limit, int32_t last = -1) const {
        std::fill(best.begin(), best.end(), Found{limit, last});
        if (square_to(whole, 0, place) <= limit) descend(shape.levels - 1, 0, place, best);
    }

    // The leaves whose boxes' squares from a box are at most a limit.
    void leaves_within(const double *low, const double *high, double limit, std::vector<int64_t> &found) const {
        found.clear();
        collect(shape.levels - 1, 0, low, high, limit, found);
    }

  private:
    const Leaf *leaves;
    const Group *groups;
    Shape shape;
    Group whole;  // its first box holds all points

    void descend(int level, int64_t number, const double *place, std::vector<Found> &best) const {
        double squares[FAN];
        squares_to(groups[shape.first[level] + number], place, place, squares);
        const int held = static_cast<int>(std::min<int64_t>(FAN, shape.boxes[level] - number * FAN));
        int order[FAN], chosen = 0;  // the boxes that may hold a nearer one, nearest first
        for (int s = 0; s < held; ++s) {
            if (squares[s] > best.back().square) continue;
            int p = chosen++;
            for (; p > 0 && squares[order[p - 1]] > squares[s]; --p) order[p] = order[p - 1];
            order[p] = s;
        }
        for (int p = 0; p < chosen; ++p) {
            if (squares[order[p]] > best.back().square) return;
            const int64_t box = number * FAN + order[p];
            if (level > 0)
                descend(level - 1, box, place, best);
            else
                search(leaves[box], place, best);
        }
    }

    static void search(const Leaf &leaf, const double *place, std::vector<Found> &best) {
        double squares[LEAF];
        squares_to(leaf, place, squares);
        for (int s = 0; s < LEAF; ++s) {
            if (squares[s] > best.back().square) continue;
            if (leaf.row[s] >= 0) insert({squares[s], leaf.row[s]}, best);
        }
    }

    void collect(int level, int64_t number, const double *low, const double *high, double limit,
                 std::vector<int64_t> &found) const {
        double squares[FAN];
        squares_to(groups[shape.first[level] + number], low, high, squares);
        const int held = static_cast<int>(std::min<int64_t>(FAN, shape.boxes[level] - number * FAN));
        for (int s = 0; s < held; ++s) {
            if (squares[s] > limit) continue;
            if (level > 0)
                collect(level - 1, number * FAN + s, low, high, limit, found);
            else
                found.push_back(number * FAN + s);
        }
    }
};

// Fill the leaves and groups of a tree over points (count, 3), count > 0.
inline Tree grow(const double *points, int64_t count, Leaf *leaves, Group *groups) {
    std::vector<Entry> entries(count);
    for (int64_t i = 0; i < count; ++i)
        entries[i] = {{static_cast<float>(points[3 * i]), static_cast<float>(points[3 * i + 1]),
                       static_cast<float>(points[3 * i + 2])},
                      static_cast<int32_t>(i)};
    halve(entries.data(), entries.data() + count);
    const Shape shape(count);
    for (int64_t g = 0; g < shape.groups(); ++g)
        for (int k = 0; k < 3; ++k) {
            std::fill_n(groups[g].lower[k], FAN, FAR);
            std::fill_n(groups[g].upper[k], FAN, -FAR);
        }
    entries.resize(shape.boxes[0] * LEAF, {{}, -1});
    for (int64_t i = 0; i < shape.boxes[0] * LEAF; ++i) {
        Leaf &leaf = leaves[i / LEAF];
        Group &group = groups[i / LEAF / FAN];
        const int64_t s = i / LEAF % FAN;
        leaf.row[i % LEAF] = entries[i].row;
        for (int k = 0; k < 3; ++k) {
            const double at = leaf.at[k][i % LEAF] = i < count ? points[3 * entries[i].row + k] : FAR;
            if (i >= count) continue;
            group.lower[k][s] = std::min(group.lower[k][s], at);
            group.upper[k][s] = std::max(group.upper[k][s], at);
        }
    }
    for (int level = 1; level < shape.levels; ++level)
        for (int64_t b = 0; b < shape.boxes[level]; ++b) {
            const Group &below = groups[shape.first[level - 1] + b];
            Group &group = groups[shape.first[level] + b / FAN];
            for (int k = 0; k < 3; ++k) {
                group.lower[k][b % FAN] = *std::min_element(below.lower[k], below.lower[k] + FAN);
                group.upper[k][b % FAN] = *std::max_element(below.upper[k], below.upper[k] + FAN);
            }
        }
    return Tree(leaves, groups, count);
}

// A tree with its arrays.
class Grown {
    std::vector<Leaf> leaves;
    std::vector<Group> groups;

  public:
    Tree tree;

    Grown(const double *points, int64_t count)
        : leaves(Shape(count).boxes[0]), groups(Shape(count).groups()),
          tree(grow(points, count, leaves.data(), groups.data())) {}
    Grown(const Grown &) = delete;
};

// Distances and rows of what was found of `count` points; infinite and `count` for what was not.
inline void write(const std::vector<Found> &best, int64_t count, double *distances, int64_t *rows) {
    for (size_t j = 0; j < best.size(); ++j) {
        const bool found = best[j].row >= 0 && best[j].row < count;
        distances[j] = found ? std::sqrt(best[j].square) : FAR;
        rows[j] = found ? best[j].row : count;
    }
}

}  // namespace topple
