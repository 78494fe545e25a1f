// Convex parts that separating directions prove apart, and how far they may come together on an interval.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace {

struct Sets {
    const int64_t *frame;           // (P) that carries each part; 0 stands still
    const float *vertices;          // (P, 3, V) in that frame
    const float *centre, *radius;   // (P, 3) and (P) of a sphere around each
    const float *slack;             // (P) by how much the part stands out beyond its vertices
    const float *lower, *upper;     // (P, 3) corners of its box
    int64_t corners, parts;
};

struct Pose {
    float r[9], p[3];
};

struct Pair {
    int64_t a, b;
};

// The poses of all frames in one of m states, from (frames, 3, 4, m).
void gather(const float *poses, int64_t frames, int64_t m, int64_t state, Pose *found) {
    for (int64_t f = 0; f < frames; ++f)
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) found[f].r[3 * i + j] = poses[((f * 3 + i) * 4 + j) * m + state];
            found[f].p[i] = poses[((f * 3 + i) * 4 + 3) * m + state];
        }
}

float dot(const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

void place(const Pose &at, const float *point, float *found) {
    for (int i = 0; i < 3; ++i) found[i] = dot(at.r + 3 * i, point) + at.p[i];
}

void unit(float *v) {
    const float length = std::sqrt(dot(v, v));
    if (length > 1e-7f)
        for (int i = 0; i < 3; ++i) v[i] /= length;
    else
        v[0] = v[1] = 0.0f, v[2] = 1.0f;
}

// The point of a part that lies farthest along a direction.
void support(const Sets &sets, int64_t part, const Pose &at, const float *direction, float sign, float *found) {
    float local[3];
    for (int j = 0; j < 3; ++j)
        local[j] = sign * (direction[0] * at.r[j] + direction[1] * at.r[3 + j] + direction[2] * at.r[6 + j]);
    const int64_t n = sets.corners;
    const float *x = sets.vertices + 3 * n * part, *y = x + n, *z = y + n;
    float along[64], most = -INFINITY;
    int64_t best = 0;
    for (int64_t first = 0; first < n; first += 64) {
        const int64_t count = std::min<int64_t>(64, n - first);
        for (int64_t v = 0; v < count; ++v)
            along[v] = local[0] * x[first + v] + local[1] * y[first + v] + local[2] * z[first + v];
        for (int64_t v = 0; v < count; ++v)
            if (along[v] > most) most = along[v], best = first + v;
    }
    const float corner[3] = {x[best], y[best], z[best]};
    place(at, corner, found);
}

// A lower bound of the distance of two parts, improved until it is enough.
float gap_of(const Sets &sets, const Pose *at, Pair pair, const float *first, float need, int64_t iterations) {
    const float slack = sets.slack[pair.a] + sets.slack[pair.b], enough = need + slack;
    const Pose &pa = at[sets.frame[pair.a]], &pb = at[sets.frame[pair.b]];
    float d[3] = {first[0], first[1], first[2]}, point[3], best = -INFINITY;
    unit(d);
    for (int64_t k = 0; k < iterations; ++k) {
        float one[3], other[3], edge[3];
        support(sets, pair.a, pa, d, -1.0f, one);
        support(sets, pair.b, pb, d, 1.0f, other);
        for (int i = 0; i < 3; ++i) one[i] -= other[i];
        const float gap = dot(one, d);
        best = std::max(best, gap - slack);
        if (gap > enough || k == iterations - 1) break;
        if (k == 0) {
            place(pa, sets.centre + 3 * pair.a, point);
            place(pb, sets.centre + 3 * pair.b, other);
            for (int i = 0; i < 3; ++i) point[i] -= other[i];
        }
        for (int i = 0; i < 3; ++i) edge[i] = one[i] - point[i];  // Gilbert: as near to the origin as it comes
        const float share = -dot(point, edge) / std::max(dot(edge, edge), 1e-14f);
        for (int i = 0; i < 3; ++i) point[i] += std::min(std::max(share, 0.0f), 1.0f) * edge[i];
        std::copy_n(point, 3, d);
        unit(d);
    }
    return best;
}

// Where the spheres' middles are.
void centres_of(const Sets &sets, const Pose *at, std::vector<float> &found) {
    for (int64_t part = 0; part < sets.parts; ++part)
        place(at[sets.frame[part]], sets.centre + 3 * part, found.data() + 3 * part);
}

// From the nearest point of a standing part's box to a place; from inside, out through the nearest face.
void from_box(const Sets &sets, int64_t part, const float *place, float *found) {
    const float *lower = sets.lower + 3 * part, *upper = sets.upper + 3 * part;
    float least = INFINITY, offset[3];
    int axis = 0;
    for (int i = 0; i < 3; ++i) {
        const float half = (upper[i] - lower[i]) / 2;
        offset[i] = place[i] - (lower[i] + upper[i]) / 2;
        found[i] = offset[i] - std::min(std::max(offset[i], -half), half);
        if (half - std::abs(offset[i]) < least) least = half - std::abs(offset[i]), axis = i;
    }
    if (found[0] == 0.0f && found[1] == 0.0f && found[2] == 0.0f) found[axis] = offset[axis] < 0.0f ? -1.0f : 1.0f;
}

}  // namespace

extern "C" {

// Lower bounds of the distances of part pairs in states, (3) a first direction and what is enough for each.
void separation_gaps(const Sets *sets, const float *poses, int64_t frames, int64_t m, const int64_t *state,
                     const int64_t *a, const int64_t *b, int64_t count, const float *direction, const float *need,
                     int64_t iterations, float *found) {
    std::vector<Pose> at(frames);
    for (int64_t t = 0; t < count; ++t) {
        if (t == 0 || state[t] != state[t - 1]) gather(poses, frames, m, state[t], at.data());
        found[t] = gap_of(*sets, at.data(), {a[t], b[t]}, direction + 3 * t, need[t], iterations);
    }
}

// The pairs (a, b) that are not proven apart by what they need, in each of m states: how many, and the first
// `room` of them, with state and gap. `held`: only what the last frame carries against what stands.
int64_t separation_open(const Sets *sets, const float *poses, int64_t frames, int64_t m, const int64_t *pairs,
                        const float *need, int64_t count, int64_t held, int64_t iterations, int64_t room,
                        int64_t *states, int64_t *which, float *gaps) {
    std::vector<Pose> at(frames);
    std::vector<float> centre(3 * sets->parts);
    int64_t found = 0;
    for (int64_t state = 0; state < m; ++state) {
        gather(poses, frames, m, state, at.data());
        centres_of(*sets, at.data(), centre);
        for (int64_t k = 0; k < count; ++k) {
            const int64_t a = pairs[2 * k], b = pairs[2 * k + 1];
            const bool stands = sets->frame[b] == 0;
            if (held && !(stands && sets->frame[a] == frames - 1)) continue;
            const float *one = centre.data() + 3 * a, *other = centre.data() + 3 * b;
            float away[3], reach = sets->radius[a] + (stands ? need[k] : sets->radius[b]);
            if (stands) {
                float square = 0.0f;
                for (int i = 0; i < 3; ++i) {
                    const float past = std::max(std::max(sets->lower[3 * b + i] - one[i], one[i] - sets->upper[3 * b + i]), 0.0f);
                    square += past * past;
                }
                if (square > reach * reach) continue;
                from_box(*sets, b, one, away);
            } else {
                for (int i = 0; i < 3; ++i) away[i] = one[i] - other[i];
                if (dot(away, away) > reach * reach) continue;
            }
            const float gap = gap_of(*sets, at.data(), {a, b}, away, need[k], iterations);
            if (gap > need[k]) continue;
            if (found < room) states[found] = state, which[found] = k, gaps[found] = gap;
            ++found;
        }
    }
    return found;
}

// For items (an interval, a pair of parts): by how much the motion within the interval can bring the two
// together, and a lower bound of their distance in its middle state, where spheres do not vouch for enough.
void separation_intervals(const Sets *sets, const float *poses, int64_t frames, int64_t m, const float *axes,
                          const uint8_t *turns, const float *spans, const int64_t *item, const int64_t *a,
                          const int64_t *b, int64_t count, const float *wanted, int64_t iterations, float *motion,
                          float *apart) {
    const int64_t parts = sets->parts, joints = frames - 1;
    std::vector<Pose> at(frames * m);
    std::vector<float> middles(3 * parts * m), bounds(frames * parts * m, 0.0f), centre(3 * parts);
    for (int64_t state = 0; state < m; ++state) {
        Pose *here = at.data() + frames * state;
        float *moved = bounds.data() + frames * parts * state;  // (frames, parts) as seen from each frame
        gather(poses, frames, m, state, here);
        centres_of(*sets, here, centre);
        std::copy(centre.begin(), centre.end(), middles.begin() + 3 * parts * state);
        for (int64_t j = joints - 1; j >= 0; --j) {
            const float span = spans[joints * state + j];
            float axis[3];
            for (int i = 0; i < 3; ++i) axis[i] = dot(here[j + 1].r + 3 * i, axes + 3 * j);
            for (int64_t part = 0; part < parts; ++part) {
                if (sets->frame[part] <= j) continue;
                float before = moved[(j + 1) * parts + part], arm[3];
                for (int i = 0; i < 3; ++i) arm[i] = centre[3 * part + i] - here[j + 1].p[i];
                const float along = dot(arm, axis);
                const float radius = std::sqrt(std::max(dot(arm, arm) - along * along, 0.0f)) + sets->radius[part];
                moved[j * parts + part] = before + (turns[j] ? span * (radius + before) : span);
            }
        }
    }
    for (int64_t t = 0; t < count; ++t) {
        const int64_t fa = sets->frame[a[t]], fb = sets->frame[b[t]];
        const float *one = middles.data() + 3 * (parts * item[t] + a[t]);
        const float *other = middles.data() + 3 * (parts * item[t] + b[t]);
        motion[t] = bounds[(frames * item[t] + std::min(fa, fb)) * parts + (fa > fb ? a[t] : b[t])];
        float away[3], radii = sets->radius[a[t]] + (fb ? sets->radius[b[t]] : 0.0f);
        for (int i = 0; i < 3; ++i) {
            const float *low = sets->lower + 3 * b[t], *high = sets->upper + 3 * b[t];
            away[i] = one[i] - (fb ? other[i] : std::min(std::max(one[i], low[i]), high[i]));
        }
        const float need = motion[t] + wanted[t];
        apart[t] = std::sqrt(dot(away, away)) - radii;
        if (apart[t] > need) continue;
        if (away[0] == 0.0f && away[1] == 0.0f && away[2] == 0.0f)
            for (int i = 0; i < 3; ++i) away[i] = one[i] - other[i];
        apart[t] = gap_of(*sets, at.data() + frames * item[t], {a[t], b[t]}, away, need, iterations);
    }
}
}
