// A tree of boxes over points in space: the nearest neighbours of places, and all within a radius of them.
//
// Points are halved across their longest side until leaves of 32 are left; eight boxes in a row share a box above
// them, up to one group of boxes. The arrays are the caller's, so nothing here is kept or freed.
// Distances are sums of squares in the order of the axes, without fused products: a box is never further than
// what lies in it, to the last bit.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace {

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
};

struct Entry {
    double at[3];
    int32_t row;
};

// Halve points across their longest side, again and again, into whole leaves.
void halve(Entry *begin, Entry *end) {
    const int64_t leaves = (end - begin + LEAF - 1) / LEAF;
    if (leaves < 2) return;
    double lower[3] = {FAR, FAR, FAR}, upper[3] = {-FAR, -FAR, -FAR};
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

// Squares of the distances of a place from the boxes of a group.
inline void squares_to(const Group &group, const double *place, double *squares) {
    double beside[3][FAN];
    for (int k = 0; k < 3; ++k)
        for (int s = 0; s < FAN; ++s) {
            const double below = group.lower[k][s] - place[k], above = place[k] - group.upper[k][s];
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

class Tree {
  public:
    Tree(const Leaf *leaves, const Group *groups, int64_t count) : leaves(leaves), groups(groups), shape(count) {}

    // The nearest of a place, those in `best` replaced by nearer ones; it stays sorted.
    void nearest(const double *place, std::vector<Found> &best) const {
        descend(shape.levels - 1, 0, place, best);
    }

    // Rows of the points whose square is at most a limit.
    void within(const double *place, double limit, std::vector<int32_t> &rows) const {
        gather(shape.levels - 1, 0, place, limit, rows);
    }

  private:
    const Leaf *leaves;
    const Group *groups;
    Shape shape;

    void descend(int level, int64_t number, const double *place, std::vector<Found> &best) const {
        double squares[FAN];
        squares_to(groups[shape.first[level] + number], place, squares);
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
            const Found one{squares[s], leaf.row[s]};
            if (one.row < 0 || !(one < best.back())) continue;
            size_t p = best.size() - 1;
            for (; p > 0 && one < best[p - 1]; --p) best[p] = best[p - 1];
            best[p] = one;
        }
    }

    void gather(int level, int64_t number, const double *place, double limit, std::vector<int32_t> &rows) const {
        double squares[LEAF];
        squares_to(groups[shape.first[level] + number], place, squares);
        const int held = static_cast<int>(std::min<int64_t>(FAN, shape.boxes[level] - number * FAN));
        double points[LEAF];
        for (int s = 0; s < held; ++s) {
            if (squares[s] > limit) continue;
            const int64_t box = number * FAN + s;
            if (level > 0) {
                gather(level - 1, box, place, limit, rows);
                continue;
            }
            squares_to(leaves[box], place, points);
            for (int p = 0; p < LEAF; ++p)
                if (points[p] <= limit && leaves[box].row[p] >= 0) rows.push_back(leaves[box].row[p]);
        }
    }
};

}  // namespace

extern "C" {

// Bytes of the leaves and of the groups of a tree over so many points.
void tree_sizes(int64_t count, int64_t *leaves, int64_t *groups) {
    const Shape shape(count);
    *leaves = shape.boxes[0] * static_cast<int64_t>(sizeof(Leaf));
    *groups = shape.first[shape.levels] * static_cast<int64_t>(sizeof(Group));
}

// Fill the leaves and groups of a tree over points (count, 3), count > 0.
void tree_build(const double *points, int64_t count, Leaf *leaves, Group *groups) {
    std::vector<Entry> entries(count);
    for (int64_t i = 0; i < count; ++i)
        entries[i] = {{points[3 * i], points[3 * i + 1], points[3 * i + 2]}, static_cast<int32_t>(i)};
    halve(entries.data(), entries.data() + count);
    const Shape shape(count);
    for (int64_t g = 0; g < shape.first[shape.levels]; ++g)
        for (int k = 0; k < 3; ++k) {
            std::fill_n(groups[g].lower[k], FAN, FAR);
            std::fill_n(groups[g].upper[k], FAN, -FAR);
        }
    entries.resize(shape.boxes[0] * LEAF, {{FAR, FAR, FAR}, -1});
    for (int64_t i = 0; i < shape.boxes[0] * LEAF; ++i) {
        Leaf &leaf = leaves[i / LEAF];
        Group &group = groups[i / LEAF / FAN];
        const int64_t s = i / LEAF % FAN;
        leaf.row[i % LEAF] = entries[i].row;
        for (int k = 0; k < 3; ++k) {
            const double at = leaf.at[k][i % LEAF] = entries[i].at[k];
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
}

// The `most` nearest points of places (asked, 3): (asked, most) distances and rows, rising; infinite and
// `count` beyond what there is below a bound.
void tree_nearest(const Leaf *leaves, const Group *groups, int64_t count, const double *points,
                  const double *places, int64_t asked, int64_t most, double bound, double *distances,
                  int64_t *rows) {
    const Tree tree(leaves, groups, count);
    std::vector<Found> best(most);
    for (int64_t q = 0; q < asked; ++q) {
        const double *place = places + 3 * q;
        Found last{bound * bound, -1};
        // The neighbours of the place before are neighbours, if not the nearest: they bound how far these are.
        double known = -1.0;
        for (int64_t j = 0; j < most; ++j) {
            if (q == 0 || rows[(q - 1) * most + j] >= count) {
                known = FAR;
                break;
            }
            const double *point = points + 3 * rows[(q - 1) * most + j];
            const double x = point[0] - place[0], y = point[1] - place[1], z = point[2] - place[2];
            known = std::max(known, x * x + y * y + z * z);
        }
        if (known < last.square) last = {known, std::numeric_limits<int32_t>::max()};
        std::fill(best.begin(), best.end(), last);
        tree.nearest(place, best);
        for (int64_t j = 0; j < most; ++j) {
            const bool found = best[j].row >= 0 && best[j].row < count;
            distances[q * most + j] = found ? std::sqrt(best[j].square) : FAR;
            rows[q * most + j] = found ? best[j].row : count;
        }
    }
}

// Rows of the points within a radius of each of some places, one place after the other and rising for each:
// how many each place has, and how many all have; no more than `room` rows are written.
int64_t tree_within(const Leaf *leaves, const Group *groups, int64_t count, const double *places, int64_t asked,
                    double radius, int64_t *counts, int64_t *rows, int64_t room) {
    const Tree tree(leaves, groups, count);
    std::vector<int32_t> near;
    int64_t total = 0;
    for (int64_t q = 0; q < asked; ++q) {
        near.clear();
        tree.within(places + 3 * q, radius * radius, near);
        std::sort(near.begin(), near.end());
        counts[q] = static_cast<int64_t>(near.size());
        if (total + counts[q] <= room) std::copy(near.begin(), near.end(), rows + total);
        total += counts[q];
    }
    return total;
}

// Sums (count,) of the weights of all points within a radius of each point, itself among them.
void tree_sums(const Leaf *leaves, const Group *groups, int64_t count, const double *points, double radius,
               const double *weights, double *sums) {
    const Tree tree(leaves, groups, count);
    std::vector<int32_t> near;
    for (int64_t q = 0; q < count; ++q) {
        near.clear();
        tree.within(points + 3 * q, radius * radius, near);
        sums[q] = 0.0;
        for (const int32_t row : near) sums[q] += weights[row];
    }
}
}
