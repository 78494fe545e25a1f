"""The paper's fourteen scenes, rebuilt: layouts, what is seen of them, and what is true."""
