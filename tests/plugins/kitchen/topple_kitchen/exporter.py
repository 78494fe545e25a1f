def numbered(plan):  # text, or bytes
    return "".join(f"{n}. {step.action} {step.object}\n" for n, step in enumerate(plan.steps, 1))
