"""The equations of motion in eleven forms, written once for any scalar."""
