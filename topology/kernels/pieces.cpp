// What hangs together by links: union-find.
#include <cstdint>
#include <vector>

// Numbers (count,) of the pieces that links (linked, 2) between rows join, in the order of their first rows.
extern "C" void pieces_of_links(const int64_t *links, int64_t linked, int64_t count, int64_t *numbers) {
    std::vector<int64_t> parent(count);
    for (int64_t i = 0; i < count; ++i) parent[i] = i;
    const auto root = [&](int64_t i) {
        while (parent[i] != i) i = parent[i] = parent[parent[i]];  // halves the way for those that come later
        return i;
    };
    for (int64_t l = 0; l < linked; ++l) {
        const int64_t a = root(links[2 * l]), b = root(links[2 * l + 1]);
        if (a < b)
            parent[b] = a;
        else
            parent[a] = b;
    }
    int64_t pieces = 0;
    for (int64_t i = 0; i < count; ++i) {  // a root comes before what hangs on it
        const int64_t first = root(i);
        numbers[i] = first == i ? pieces++ : numbers[first];
    }
}
