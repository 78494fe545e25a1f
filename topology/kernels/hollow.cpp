// How hollow a cloud is: how deep points lie below its hull, and how far faces of the hull are from any point.
#include <array>

#include "tree.hpp"

using namespace topple;

namespace {

constexpr double FLAT = 1e-5;       // [m] of a thinner cloud there is no hull here
constexpr double ROUNDING = 1e-10;  // of a cloud's extent: what stands out less is no corner

using Place = std::array<double, 3>;

Place at(const double *row) { return {row[0], row[1], row[2]}; }
Place operator-(const Place &a, const Place &b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double dot(const Place &a, const Place &b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Place cross(const Place &a, const Place &b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

struct Face {
    std::array<int64_t, 3> corners;  // rows, to the left from outside, the least along x first
    Place normal;                    // outward, of unit length
    double area;                     // twice that of the face [m²]
    Place middle;                    // three times as far out

    bool operator<(const Face &other) const { return middle < other.middle; }
};

// The hull of a cloud, corner after corner: what a corner sees of it gives way to a cone from there.
struct Hull {
    const double *points;
    const int64_t count;
    double extent = 0.0;           // [m]
    std::vector<Face> faces;
    std::vector<double> offsets;   // of the planes of faces, in a frame at the first point
    std::vector<int64_t> outside;  // for each face the first of the points out there, no point for two faces, or -1
    std::vector<int64_t> next;     // the point after each

    Hull(const double *points, int64_t count) : points(points), count(count), next(count) {}

    Place from_first(int64_t row) const { return at(points + 3 * row) - at(points); }

    double beyond(size_t face, const Place &place) const { return dot(faces[face].normal, place) + offsets[face]; }

    void add(int64_t a, int64_t b, int64_t c) {
        while (points[3 * b] < points[3 * a] || points[3 * c] < points[3 * a]) std::swap(a, b), std::swap(b, c);
        const Place one = at(points + 3 * a), two = at(points + 3 * b), three = at(points + 3 * c);
        Place normal = cross(two - one, three - one), middle;
        const double area = std::sqrt(dot(normal, normal));
        for (int k = 0; k < 3; ++k) normal[k] /= area, middle[k] = one[k] + two[k] + three[k];
        faces.push_back({{a, b, c}, normal, area, middle});
        offsets.push_back(-dot(normal, from_first(a)));
        outside.push_back(-1);
    }

    // Give a point to the first face from one on that it is outside of, if there is one.
    void give(int64_t row, size_t face) {
        const Place place = from_first(row);
        while (face < faces.size() && !(beyond(face, place) > ROUNDING * extent)) ++face;
        if (face < faces.size()) next[row] = outside[face], outside[face] = row;
    }

    void include(int64_t corner) {
        const Place place = from_first(corner);
        std::vector<std::array<int64_t, 2>> rim;
        std::vector<int64_t> left;
        for (size_t f = faces.size(); f-- > 0;) {
            if (!(beyond(f, place) > ROUNDING * extent)) continue;
            for (int k = 0; k < 3; ++k) {
                const int64_t from = faces[f].corners[k], to = faces[f].corners[(k + 1) % 3];
                const auto same = std::find(rim.begin(), rim.end(), std::array<int64_t, 2>{to, from});
                if (same == rim.end())
                    rim.push_back({from, to});
                else
                    *same = rim.back(), rim.pop_back();
            }
            for (int64_t row = outside[f]; row >= 0; row = next[row])
                if (row != corner) left.push_back(row);
            faces[f] = faces.back(), offsets[f] = offsets.back(), outside[f] = outside.back();
            faces.pop_back(), offsets.pop_back(), outside.pop_back();
        }
        const size_t first = faces.size();
        for (const auto &side : rim) add(side[0], side[1], corner);
        for (int64_t row : left) give(row, first);
    }

    template <typename Measure> int64_t furthest(const Measure &measure) const {
        int64_t best = 0;
        for (int64_t i = 1; i < count; ++i)
            if (measure(from_first(i)) > measure(from_first(best))) best = i;
        return best;
    }

    // How deep the points lie below the hull, (count,); whether there is a hull, and rounding decides nothing.
    bool build(std::vector<double> &depth) {
        const int64_t a = furthest([](const Place &p) { return dot(p, p); });
        const Place first = from_first(a);
        const int64_t b = furthest([&](const Place &p) { return dot(p - first, p - first); });
        const Place along = from_first(b) - first;
        const auto across = [&](const Place &p) { return cross(along, p - first); };
        const int64_t c = furthest([&](const Place &p) { return dot(across(p), across(p)); });
        const Place normal = across(from_first(c));
        const int64_t d = furthest([&](const Place &p) { return std::fabs(dot(normal, p - first)); });
        const double height = dot(normal, from_first(d) - first);
        if (!(std::fabs(height) > FLAT * std::sqrt(dot(normal, normal)))) return false;
        extent = std::sqrt(dot(along, along));
        const int64_t left = height < 0 ? a : b, right = height < 0 ? b : a;
        add(left, right, c), add(right, left, d), add(c, right, d), add(left, c, d);
        for (int64_t i = 0; i < count; ++i) give(i, 0);
        for (size_t f = 0; f < faces.size();) {
            int64_t corner = outside[f++];
            if (corner < 0) continue;
            for (int64_t row = next[corner]; row >= 0; row = next[row])
                if (beyond(f - 1, from_first(row)) > beyond(f - 1, from_first(corner))) corner = row;
            include(corner);
            f = 0;  // others stand there now
        }
        std::vector<double> columns[3];
        for (int64_t i = 0; i < count; ++i)
            for (int k = 0; k < 3; ++k) columns[k].push_back(from_first(i)[k]);
        const double *x = columns[0].data(), *y = columns[1].data(), *z = columns[2].data();
        depth.assign(count, FAR);
        for (size_t f = 0; f < faces.size(); ++f) {
            const double u = faces[f].normal[0], v = faces[f].normal[1], w = faces[f].normal[2], offset = offsets[f];
            for (int64_t i = 0; i < count; ++i) {
                const double under = -(u * x[i] + v * y[i] + w * z[i] + offset);
                depth[i] = under < depth[i] ? under : depth[i];
            }
        }
        const auto [least, most] = std::minmax_element(depth.begin(), depth.end());
        return *least > -8 * ROUNDING * extent && *most < FAR;
    }
};

struct Cut {  // the plane axis . x = limit
    double axis[3], limit;
};

struct Judge {
    const double *eyes, *outline;  // (eye, 3) and (size, 3)
    const Cut *cuts;
    int64_t eye, size, cut;
    double spacing, reach;  // of neighbouring points, and of those of the outline [m]
    double section;         // cosine from which on a face is square to a cut's axis

    // Whether a place lies on a cut through solid: straight out from there the object goes on.
    bool in_section(const Place &place, const Place &normal) const {
        const bool beside = std::any_of(cuts, cuts + cut, [&](const Cut &one) {
            const bool near = std::fabs(dot(place, at(one.axis)) - one.limit) < 3 * spacing;
            return near && std::fabs(dot(normal, at(one.axis))) > section;
        });
        for (int64_t i = 0; beside && i < size; ++i) {
            const Place offset = at(outline + 3 * i) - place;
            const double along = dot(offset, normal);
            if (along > reach && dot(offset, offset) - along * along < reach * reach) return true;
        }
        return false;
    }

    // How far from any point those of some places are, on faces that look at an eye, that a tenth exceeds.
    double bare(Hull &hull, int64_t samples) const {
        std::sort(hull.faces.begin(), hull.faces.end());  // an order that hangs on places alone
        std::vector<double> running, distances;
        double expected = 0.0, whole = 0.0;
        for (const Face &face : hull.faces) {
            const Place corner = at(hull.points + 3 * face.corners[0]);
            bool looks = eye == 0;
            for (int64_t e = 0; e < eye; ++e) looks |= dot(at(eyes + 3 * e) - corner, face.normal) > 0;
            whole += face.area;
            running.push_back(expected += looks ? face.area : 0.0);
        }
        if (expected < 0.02 * whole) return 0.0;
        const Grown grown(hull.points, hull.count);
        std::vector<Found> nearest(1);
        for (int64_t i = 0; i < samples; ++i) {  // at fixed shares of the running sum
            const double share = (static_cast<double>(i) + 0.5) / static_cast<double>(samples);
            const auto above = std::lower_bound(running.begin(), running.end() - 1, share * expected);
            const Face &face = hull.faces[above - running.begin()];
            const double u = std::sqrt(std::fmod(static_cast<double>(i) * 0.618034, 1.0));
            const double v = std::fmod(static_cast<double>(i) * 0.754878, 1.0);
            const double weight[3] = {1 - u, u * (1 - v), u * v};
            Place place{};
            for (int j = 0; j < 3; ++j)
                for (int k = 0; k < 3; ++k) place[k] += weight[j] * hull.points[3 * face.corners[j] + k];
            if (in_section(place, face.normal)) continue;
            grown.tree.nearest(place.data(), nearest, FAR);
            distances.push_back(std::sqrt(nearest[0].square) - 2 * spacing);
        }
        if (static_cast<int64_t>(distances.size()) < samples / 16) return 0.0;
        std::sort(distances.begin(), distances.end());
        const double rank = 0.9 * static_cast<double>(distances.size() - 1);
        const size_t below = static_cast<size_t>(rank), next = std::min(below + 1, distances.size() - 1);
        const double found = distances[below] + (rank - std::floor(rank)) * (distances[next] - distances[below]);
        return std::max(0.0, found);
    }
};

}  // namespace

// How hollow points (count, 3) are [m]: the depth of typical deep ones below their hull, or where there are eyes
// (eye, 3), by none of them all around, the width of typical bare faces, if that is more and the depth not `enough`.
// Cuts (cut, 4) made the piece of an object, which outline (size, 3) shows. Marks the corners of the hull (count,).
// NaN where the points have no hull with an inside, or rounding decides about it.
extern "C" double hollow_hull(const double *points, int64_t count, const double *eyes, int64_t eye, const double *cuts,
                              int64_t cut, const double *outline, int64_t size, double spacing, double reach,
                              double section, double enough, int64_t samples, bool *corners) {
    Hull hull(points, count);
    std::vector<double> depth;
    if (!hull.build(depth)) return std::numeric_limits<double>::quiet_NaN();
    for (const Face &face : hull.faces)
        for (int64_t row : face.corners) corners[row] = true;
    const auto deep = depth.begin() + (count - 1 - count / 50);
    std::nth_element(depth.begin(), deep, depth.end());
    if (eyes == nullptr || *deep >= enough) return *deep;
    const Judge judge{eyes, outline, reinterpret_cast<const Cut *>(cuts), eye, size, cut, spacing, reach, section};
    return std::max(*deep, judge.bare(hull, samples));
}
