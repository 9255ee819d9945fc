// Asks before forces go out, and says what that means.

import { button, h, setText } from "../ui/dom";

export class ArmDialog {
  readonly element: HTMLDialogElement;
  private readonly statement = h("p");
  private readonly last = h("input", { type: "checkbox", checked: true });

  /** `arm` is told whether forces are to outlast the page. */
  constructor(arm: (keep: boolean) => void) {
    const go = () => {
      this.element.close();
      arm(!this.last.checked);
    };
    this.element = h(
      "dialog",
      { class: "arm-dialog", "aria-labelledby": "arm-title" },
      h("h2", { id: "arm-title" }, "Let forces through?"),
      this.statement,
      h("label", {}, this.last, "End forces when this page is closed or loses its connection"),
      h("p", {}, h("kbd", {}, "Esc"), " stops all forces at any time."),
      h(
        "div",
        { class: "buttons" },
        // Has the focus, so that Enter does not arm.
        button("Cancel", () => this.element.close(), { autofocus: true }),
        button("Arm", go, { class: "arm" }),
      ),
    );
  }

  ask(statement: string): void {
    setText(this.statement, statement);
    // The safe choice each time.
    this.last.checked = true;
    this.element.showModal();
  }
}
