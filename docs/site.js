// Tables, code and tabs that scroll can be reached by the keyboard; the theme wraps them after the page has come.
const reachable = () => document.querySelectorAll(".md-typeset__scrollwrap, .highlight pre, .tabbed-labels").forEach((node) => { node.tabIndex = 0; });
new MutationObserver(reachable).observe(document.body, { childList: true, subtree: true });
reachable();
